//! The daemon itself: what it is, and its end.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde_json::{Value, json};

use crate::daemon::Daemon;

/// `GET /`
pub(crate) async fn about(State(daemon): State<Arc<Daemon>>) -> Json<Value> {
    Json(json!({
        "genomd": env!("CARGO_PKG_VERSION"),
        "pid": std::process::id(),
        "backend": daemon.settings.backend,
        "resources": ["/components", "/connections", "/deployment", "/ports", "/clock", "/logs", "/metrics", "/middlewares", "/events", "/shutdown"],
    }))
}

/// `POST /shutdown`: answers at once; the end of `GET /events` tells when it is done.
pub(crate) async fn shutdown(State(daemon): State<Arc<Daemon>>) -> (StatusCode, Json<Value>) {
    daemon.ask_to_stop("asked over the control plane");
    (StatusCode::ACCEPTED, Json(json!({"stopping": true})))
}
