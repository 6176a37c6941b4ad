//! Activities: list, look, wait, abort.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_cells::Cells;
use genom_doors::{Parameters, RpcError};
use genom_protocol::{Aborted, AbortedActivity, Activities, AllAborted, Code, LookParameters};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_views::{activities_of, find_activity};

use crate::rpc::components;

/// List the activities of a component: running ones, and those that ended recently.
#[utoipa::path(
    get,
    path = "/components/{component}/activities",
    tag = "activities",
    responses((status = 200, body = Activities), (status = 404))
)]
pub(crate) async fn list(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Activities>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let all = hosted.activities.all();
    let activities = all.iter().map(|one| one.look(hosted.state(one.number))).collect();
    Ok(Json(Activities { activities }))
}

/// Describe an activity, or wait for its end. It is given by its number, or by the name of a
/// service for the latest one.
///
/// An ended activity is kept for `rpc.keep_results` seconds (configuration of the daemon). A component
/// that is being stopped still tells of its activities.
#[utoipa::path(
    get,
    path = "/components/{component}/activities/{activity}",
    tag = "activities",
    params(LookParameters),
    responses((status = 200, body = genom_protocol::Activity), (status = 404), (status = 422))
)]
pub(crate) async fn look(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, activity)): Path<(String, String)>,
    Parameters(parameters): Parameters<LookParameters>,
) -> Result<Json<genom_protocol::Activity>, RpcError> {
    let hosted = genom_views::find_until_closed(&supervisor.components, &component)?;
    let activity = match activity.parse::<u64>() {
        Ok(_) => find_activity(&hosted, &activity)?,
        Err(_) => activities_of(&hosted, &activity)?.pop().ok_or_else(|| {
            let message = format!("no {component}/{activity} runs, nor did lately");
            RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchActivity, message)
                .help(format!("`genomctl info {component} {activity}` tells what it is"))
        })?,
    };
    // Whoever waits does not keep the component, which may be stopped meanwhile.
    let hosted = Arc::downgrade(&hosted);
    if let Some(seconds) = parameters.wait {
        let wait = genom_doors::wait(seconds)?;
        // On timeout, the reply describes the running activity.
        let _ = tokio::time::timeout(wait, activity.ended()).await;
    }
    let state = hosted.upgrade().and_then(|hosted| hosted.state(activity.number));
    Ok(Json(activity.look(state)))
}

/// Ask an activity to stop, given by its number, or all activities of a service, given by its name.
#[utoipa::path(
    delete,
    path = "/components/{component}/activities/{activity}",
    tag = "activities",
    responses((status = 200, body = Aborted), (status = 404), (status = 409))
)]
pub(crate) async fn abort(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, activity)): Path<(String, String)>,
) -> Result<Json<Aborted>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let chosen = match activity.parse::<u64>() {
        Ok(number) => {
            let found = find_activity(&hosted, &activity)?;
            if found.outcome().is_some() {
                let message = format!("activity {number} of {component} has already ended");
                return Err(RpcError::conflict(Code::Ended, message));
            }
            vec![found]
        }
        Err(_) => activities_of(&hosted, &activity)?,
    };
    let aborted = chosen
        .iter()
        .filter(|activity| activity.outcome().is_none() && hosted.abort(activity.number))
        .map(|activity| activity.number)
        .collect();
    Ok(Json(Aborted { aborted }))
}

/// Ask every activity of a component to stop.
#[utoipa::path(
    delete,
    path = "/components/{component}/activities",
    tag = "activities",
    responses((status = 200, body = AllAborted), (status = 404))
)]
pub(crate) async fn abort_all(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<AllAborted>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    Ok(Json(AllAborted { aborted: aborted(&hosted) }))
}

/// Ask every activity of every component to stop.
///
/// Replies when all of them were asked, with those that had not ended.
#[utoipa::path(
    delete,
    path = "/activities",
    tag = "activities",
    responses((status = 200, body = AllAborted))
)]
pub(crate) async fn stop(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> Json<AllAborted> {
    let all = supervisor.components.all();
    let aborted: Vec<AbortedActivity> = all.iter().flat_map(|hosted| aborted(hosted)).collect();
    drop(all);
    let mut all = AllAborted { aborted };
    cells.join_stopped(&mut all).await;
    tracing::info!("all activities were told to stop: {} ran", all.aborted.len());
    Json(all)
}

fn aborted(hosted: &Hosted) -> Vec<AbortedActivity> {
    let told = hosted.abort_all().into_iter();
    let component = || hosted.name.clone();
    told.map(|(activity, service)| AbortedActivity { component: component(), service, activity })
        .collect()
}
