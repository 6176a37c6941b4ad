//! Requests to and from other daemons, through middlewares that pass them on: a fleet is
//! supervised from one daemon, and no robot opens a TCP port.
//!
//! What passes here is sealed by the client and the daemon that is meant (`genom_proof`): this
//! daemon cannot read a token, ask in the client's name, or answer for the other daemon.
//! `asking` passes messages on, `answering` takes those to this daemon.

pub(super) mod answering;
pub(super) mod asking;
mod sessions;
mod streams;

use std::sync::Arc;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_middleware::Middleware;
use genom_protocol::{Code, Daemons, VisibleDaemon};

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;

pub(crate) use answering::announce;

/// Header by which old clients named another daemon, and sent it their token.
const OLD_HEADER: &str = "genomd-daemon";

/// List the daemons that are visible on middlewares.
///
/// A name is no proof: anybody there may show any. `genomctl --host zenoh:NAME` has the daemon
/// prove that it holds the token, and shows it to nobody.
#[utoipa::path(
    get,
    path = "/daemons",
    tag = "daemon",
    security(("token" = ["read"])),
    responses((status = 200, body = Daemons))
)]
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Daemons> {
    let mut daemons = Vec::new();
    for (backend, open) in relays(&daemon) {
        match open.relay().map(|relay| relay.daemons()) {
            Some(Ok(names)) => {
                let visible = |name| VisibleDaemon { name, backend: backend.to_owned() };
                daemons.extend(names.into_iter().map(visible));
            }
            Some(Err(error)) => tracing::warn!("daemons on {backend}: {error}"),
            None => {}
        }
    }
    Json(Daemons { own: daemon.announcements.name(), daemons })
}

fn relays(daemon: &Daemon) -> Vec<(&'static str, Arc<dyn Middleware>)> {
    let open = genom_registry::known().iter();
    let open = open.filter_map(|known| Some((known.name, daemon.backends.opened(known.name)?)));
    open.filter(|(_, open)| open.relay().is_some()).collect()
}

/// Refuses what was meant for another daemon: it must not be done by this one.
pub(super) async fn refuse_old(request: Request, next: Next) -> Response {
    if !request.headers().contains_key(OLD_HEADER) {
        return next.run(request).await;
    }
    let message = "requests to other daemons are not passed on with a token any more: it would go \
                   to whoever answers to the name";
    RpcError::new(StatusCode::BAD_REQUEST, Code::OldClient, message)
        .help("use the genomctl or the Python client of this version")
        .into_response()
}
