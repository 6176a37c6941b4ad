//! Signs of life that the service manager does not get since a component broke a rule.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_cells::Cells;
use genom_protocol::{Cleared, Withheld, WithheldFor, routes};
use genom_supervisor::Supervisor;

/// List the components because of which the service manager gets no sign of life.
#[utoipa::path(
    get,
    path = "/withheld",
    tag = "daemon",
    responses((status = 200, body = Withheld))
)]
pub(crate) async fn list(State(supervisor): State<Arc<Supervisor>>) -> Json<Withheld> {
    let one = |(component, why)| WithheldFor { component, why };
    Json(Withheld { withheld: supervisor.withheld.all().into_iter().map(one).collect() })
}

/// Give signs of life again that were withheld because of a component.
///
/// It need not run any more. Those withheld because of others stay so.
#[utoipa::path(
    delete,
    path = "/withheld/{instance}",
    tag = "daemon",
    responses((status = 200, body = Cleared))
)]
pub(crate) async fn clear(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Path(instance): Path<String>,
) -> Json<Cleared> {
    let why = supervisor.withheld.clear(&instance);
    if why.is_some() {
        tracing::info!(instance, "signs of life are not withheld because of it any more");
    }
    // Its cell keeps that as well; one that does not answer forgets it when it ends.
    if let Some(cell) = cells.of(&instance) {
        let _ = cell.ask(&routes::clear_withheld(&instance)).await;
    }
    Json(Cleared { was: why })
}
