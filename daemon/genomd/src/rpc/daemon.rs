//! The daemon itself: what it is, and its end.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Serialize;
use utoipa::ToSchema;

use crate::daemon::Daemon;

/// What this daemon is.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct About {
    /// Its version.
    genomd: &'static str,
    /// Its process.
    pid: u32,
    /// Its default middleware.
    backend: String,
    /// TCP address it listens on as well.
    listen: Option<String>,
    /// Where its interface is described.
    openapi: &'static str,
}

/// A daemon that was asked to stop.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Stopping {
    stopping: bool,
}

/// Tell what this daemon is.
#[utoipa::path(
    get,
    path = "/",
    tag = "daemon",
    security(("token" = ["read"])),
    responses((status = 200, body = About))
)]
pub(crate) async fn about(State(daemon): State<Arc<Daemon>>) -> Json<About> {
    Json(About {
        genomd: env!("CARGO_PKG_VERSION"),
        pid: std::process::id(),
        backend: daemon.settings.backend.clone(),
        listen: daemon.rpc.listen.map(|address| address.to_string()),
        openapi: "/openapi.json",
    })
}

/// Stop the daemon.
///
/// Answers at once; the end of `GET /events` tells when it is done.
#[utoipa::path(
    post,
    path = "/shutdown",
    tag = "daemon",
    security(("token" = ["admin"])),
    responses((status = 202, body = Stopping))
)]
pub(crate) async fn shutdown(State(daemon): State<Arc<Daemon>>) -> (StatusCode, Json<Stopping>) {
    daemon.ask_to_stop("asked over the control plane");
    (StatusCode::ACCEPTED, Json(Stopping { stopping: true }))
}
