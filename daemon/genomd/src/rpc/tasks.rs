//! Tasks and codels: their statistics.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_doors::RpcError;
use genom_protocol::{CodelStatistics, Durations, Statistics, TaskStatistics, Yielded};
use genom_runtime as runtime;
use genom_supervisor::Supervisor;

use crate::rpc::codels::{running, unpaused};
use crate::rpc::components;

/// Get the statistics of a component's tasks and codels.
///
/// Durations are in nanoseconds: `count`, `last_ns`, `mean_ns`, `p50_ns`, `p99_ns`, `min_ns`,
/// `max_ns`.
#[utoipa::path(
    get,
    path = "/components/{component}/tasks",
    tag = "statistics",
    responses((status = 200, body = Statistics), (status = 404))
)]
pub(crate) async fn statistics(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Statistics>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let figures = hosted.figures();
    Ok(Json(Statistics {
        tasks: figures.tasks.into_iter().map(task).collect(),
        codels: figures.codels.into_iter().map(codel).collect(),
        lost_changes: figures.lost_changes,
    }))
}

fn task(of: runtime::TaskStatistics) -> TaskStatistics {
    TaskStatistics {
        name: of.name,
        period_ns: of.period_ns,
        real_time: of.real_time,
        cycles: durations(of.cycles),
        lateness: durations(of.lateness),
        overruns: of.overruns,
        stuck: of.stuck.as_ref().map(running),
        unpaused: of.unpaused.as_ref().map(unpaused),
    }
}

fn codel(of: runtime::CodelStatistics) -> CodelStatistics {
    CodelStatistics {
        name: of.name,
        owner: of.owner,
        durations: durations(of.durations),
        yielded: of.yielded.into_iter().map(|(event, count)| Yielded { event, count }).collect(),
        wcet_ns: of.wcet_ns,
        above_wcet: of.above_wcet,
    }
}

fn durations(of: runtime::Durations) -> Durations {
    let runtime::Durations { count, last_ns, mean_ns, p50_ns, p99_ns, min_ns, max_ns } = of;
    Durations { count, last_ns, mean_ns, p50_ns, p99_ns, min_ns, max_ns }
}
