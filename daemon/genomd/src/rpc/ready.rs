//! Whether the daemon has loaded the components of its configuration.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use genom_doors::{Parameters, RpcError};
use genom_protocol::{Code, Ready, ReadyParameters};
use genom_supervisor::Supervisor;

use genom_supervisor::bus::startup::Startup;

/// Get whether the daemon has loaded the components of its configuration.
///
/// 200 if so; 503 with code `not_ready` while it is loading, and with code `stopping` while it is
/// stopping. Components that are loaded by later requests are not considered: such a request
/// replies when its component runs.
#[utoipa::path(
    get,
    path = "/ready",
    tag = "daemon",
    params(ReadyParameters),
    responses((status = 200, body = Ready), (status = 422), (status = 503))
)]
pub(crate) async fn ready(
    State(supervisor): State<Arc<Supervisor>>,
    State(startup): State<Arc<Startup>>,
    Parameters(parameters): Parameters<ReadyParameters>,
) -> Result<Json<Ready>, RpcError> {
    let wanted = if parameters.deployed == Some(true) { &startup.deployed } else { &startup.ready };
    if let Some(seconds) = parameters.wait {
        let wait = genom_doors::wait(seconds)?;
        tokio::select! {
            () = wanted.raised() => {}
            () = supervisor.asked_to_stop() => {}
            () = tokio::time::sleep(wait) => {}
        }
    }
    if supervisor.stopping() {
        return Err(unavailable(Code::Stopping, "the daemon stops".to_owned()));
    }
    if wanted.is_up() {
        return Ok(Json(Ready { ready: true, deployed: startup.deployed.is_up() }));
    }
    let message = match &startup.to_load()[..] {
        [] if startup.ready.is_up() => "connections are being made".to_owned(),
        [] => "the daemon starts".to_owned(),
        [now] => format!("{now} is being loaded"),
        [now, next @ ..] => format!("{now} is being loaded, then {}", next.join(", ")),
    };
    Err(unavailable(Code::NotReady, message).help("`genomctl wait-ready` waits until it is"))
}

fn unavailable(code: Code, message: String) -> RpcError {
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, code, message)
}
