//! The daemon itself: description and shutdown.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use genom_protocol::{About, Stopping, routes};
use genom_supervisor::Supervisor;

use crate::daemon::Daemon;

/// Describe this daemon.
#[utoipa::path(
    get,
    path = "/",
    tag = "daemon",
    responses((status = 200, body = About))
)]
pub(crate) async fn about(State(daemon): State<Arc<Daemon>>) -> Json<About> {
    Json(About {
        genomd: env!("CARGO_PKG_VERSION").to_owned(),
        pid: std::process::id(),
        backend: daemon.supervisor.settings.backend.clone(),
        listen: daemon.rpc.listen.map(|address| address.to_string()),
        openapi: routes::document().path,
    })
}

/// Stop the daemon.
///
/// Replies at once. The stream of `GET /events` ends when the daemon has stopped.
#[utoipa::path(
    post,
    path = "/shutdown",
    tag = "daemon",
    responses((status = 202, body = Stopping))
)]
pub(crate) async fn shutdown(
    State(supervisor): State<Arc<Supervisor>>,
) -> (StatusCode, Json<Stopping>) {
    supervisor.ask_to_stop("asked over the control plane");
    (StatusCode::ACCEPTED, Json(Stopping { stopping: true }))
}
