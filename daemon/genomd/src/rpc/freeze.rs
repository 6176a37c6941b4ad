//! The state of the running system: written, and brought back.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_cells::{Cells, FreezeError, ThawError};
use genom_doors::{Body, RpcError};
use genom_protocol::freeze::MOST;
use genom_protocol::{Code, Frozen, GoesOn, ThawRequest, Thawed};
use genom_supervisor::Supervisor;

use crate::rpc::{cells as of_cells, components};

/// Most bytes of a request to thaw: a file, and what is around it.
pub(super) const LARGEST: usize = MOST + 1024;

/// Write the state of all components: IDS, ports, activities. Nothing is changed.
#[utoipa::path(
    post,
    path = "/freeze",
    tag = "deployment",
    responses((status = 200, body = Frozen), (status = 409))
)]
pub(crate) async fn freeze(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> Result<Json<Frozen>, RpcError> {
    tracing::info!("frozen: the state of all components is read");
    cells.freeze(&supervisor).await.map(Json).map_err(|error| match error {
        FreezeError::Own(error) => RpcError::conflict(Code::HeldUp, error.to_string()),
        FreezeError::Cell { why, .. } => of_cells::refused(why),
        FreezeError::Thread(error) => RpcError::internal(error.to_string()),
    })
}

/// Bring components back as they were: all that the request has, or none.
#[utoipa::path(
    post,
    path = "/thaw",
    tag = "deployment",
    request_body = ThawRequest,
    responses((status = 200, body = Thawed), (status = 409), (status = 422))
)]
pub(crate) async fn thaw(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Body(wanted): Body<ThawRequest>,
) -> Result<Json<Thawed>, RpcError> {
    let thawed = cells.thaw(&supervisor, wanted.frozen, wanted.replace).await;
    thawed.map(Json).map_err(|error| {
        let taken = matches!(error, ThawError::Runs(_));
        let code = if taken { Code::NameTaken } else { Code::NotApplied };
        RpcError::conflict(code, error.to_string())
    })
}

/// Let a component go on that is held: when the daemon ended while it thawed a system.
#[utoipa::path(
    post,
    path = "/components/{component}/go_on",
    tag = "components",
    responses((status = 200, body = GoesOn), (status = 404))
)]
pub(crate) async fn go_on(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<GoesOn>, RpcError> {
    components::find(&supervisor.components, &component)?.go_on();
    Ok(Json(GoesOn { goes_on: true }))
}
