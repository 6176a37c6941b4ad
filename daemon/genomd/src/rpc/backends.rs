//! Moves running components and ports to other middlewares.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_cells::Cells;
use genom_doors::{Body, RpcError};
use genom_protocol::{Code, MoveRequest, Moved, NeededEnds};
use genom_supervisor::Supervisor;
use genom_supervisor::connections::BindError;
use genom_views::{held_up, not_connected};

use crate::rpc::{components, ports};

/// Most ports of one request, with elements of multiple ones.
const MOST_ENDS: usize = 4096;

/// Move a running component, or one of its ports, to other middlewares.
#[utoipa::path(
    put,
    path = "/components/{component}/backend",
    tag = "wiring",
    request_body = MoveRequest,
    responses(
        (status = 200, body = Moved), (status = 404), (status = 422), (status = 502), (status = 503)
    )
)]
pub(crate) async fn change(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
    Body(wanted): Body<MoveRequest>,
) -> Result<Json<Moved>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let port = wanted.port.as_deref().map(|port| ports::find(&hosted, port)).transpose()?;
    if wanted.backend.names().is_empty() {
        return Err(RpcError::bad_input("a port is on one backend at least").place("/backend"));
    }
    let to = wanted.backend.clone();
    let work = move || supervisor.connections.move_to(&hosted, port, &wanted.backend);
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(())) => Ok(Json(Moved { component, port: wanted.port, backend: to })),
        Ok(Err(error @ BindError::Backend(_))) => {
            Err(RpcError::bad_input(error.to_string()).place("/backend"))
        }
        Ok(Err(BindError::HeldUp(error))) => Err(held_up(&error)),
        Ok(Err(error)) => {
            Err(RpcError::new(StatusCode::BAD_GATEWAY, Code::MiddlewareFailed, error.to_string())
                .help("nothing was changed"))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// Open out ports of a component for readers in other processes.
///
/// As a daemon asks its cells: it takes the place of what was asked before, so that what is not
/// named any more is closed, unless a connection of the same process needs it.
#[utoipa::path(
    put,
    path = "/components/{component}/ends",
    tag = "wiring",
    request_body = NeededEnds,
    responses(
        (status = 200, body = NeededEnds), (status = 404), (status = 422), (status = 502), (status = 503)
    )
)]
pub(crate) async fn need(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Path(component): Path<String>,
    Body(needed): Body<NeededEnds>,
) -> Result<Json<NeededEnds>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    if needed.ports.len() > MOST_ENDS {
        let message = format!("{} ports; {MOST_ENDS} are possible", needed.ports.len());
        return Err(RpcError::bad_input(message).place("/ports"));
    }
    for (name, over) in &needed.ports {
        for over in over.names() {
            genom_registry::check(over)
                .map_err(|error| RpcError::bad_input(error.to_string()).place("/ports"))?;
        }
        let port = name.split('/').next().unwrap_or_default();
        // A service is offered on the middlewares of its component only.
        if hosted.plan().service(name).is_none() {
            ports::find(&hosted, port)?;
        }
    }
    let asked = needed.ports.clone();
    let work = move || supervisor.connections.need_elsewhere(&hosted.name, &asked);
    let opened = tokio::task::spawn_blocking(work).await;
    cells.tell_again(&component);
    match opened {
        Ok(Ok(())) => Ok(Json(needed)),
        Ok(Err(error)) => Err(not_connected(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}
