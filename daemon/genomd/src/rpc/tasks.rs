//! Tasks: their statistics.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use serde_json::Value;

use utoipa::ToSchema;

use crate::daemon::Daemon;
use crate::rpc::components;
use crate::rpc::error::RpcError;

/// Shape of `genom_runtime::Statistics`, which knows nothing of this interface.
#[derive(ToSchema)]
#[schema(as = Statistics)]
#[allow(dead_code, reason = "only its shape is told")]
pub(crate) struct Figures {
    /// Each task: `name`, `period_ns`, `real_time`, `cycles` and `lateness` (durations),
    /// `overruns`, and while it is stuck `stuck`: `codel`, `owner`, `for_ns`; or while it is at work
    /// for long without pause `unpaused`: `codel`, `owner`, `for_ns`, `steps`. A cycle counts while it
    /// lasts.
    #[schema(value_type = Vec<Object>)]
    tasks: (),
    /// Each codel that ran: `name`, `owner`, `durations`, `wcet_ns`, `above_wcet`.
    #[schema(value_type = Vec<Object>)]
    codels: (),
    /// Changes that watchers missed because they came too fast.
    lost_changes: u64,
}

/// Tell the statistics of a component's tasks and codels.
///
/// Durations are in nanoseconds: `count`, `last_ns`, `mean_ns`, `p50_ns`, `p99_ns`, `max_ns`.
#[utoipa::path(
    get,
    path = "/components/{component}/tasks",
    tag = "statistics",
    security(("token" = ["read"])),
    responses((status = 200, body = Figures), (status = 404))
)]
pub(crate) async fn statistics(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    Ok(Json(hosted.statistics()))
}
