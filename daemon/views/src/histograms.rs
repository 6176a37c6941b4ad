//! Histograms of the durations of tasks.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_doors::RpcError;
use genom_protocol::{Bucket, Histograms, TaskHistograms};
use genom_supervisor::Supervisor;

use crate::named::find;

/// Get how often the tasks of a component took how long, since it started.
///
/// Buckets grow logarithmically. Differences between two readings are what happened between them.
#[utoipa::path(
    get,
    path = "/components/{component}/tasks/histograms",
    tag = "statistics",
    responses((status = 200, body = Histograms), (status = 404))
)]
pub async fn histograms(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Histograms>, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    let tasks = hosted.histograms().into_iter().map(|task| TaskHistograms {
        name: task.name,
        period_ns: task.period_ns,
        cycles: buckets(task.cycles),
        lateness: buckets(task.lateness),
    });
    Ok(Json(Histograms { tasks: tasks.collect() }))
}

fn buckets(of: Vec<(u64, u64)>) -> Vec<Bucket> {
    of.into_iter().map(|(most_ns, count)| Bucket { most_ns, count }).collect()
}
