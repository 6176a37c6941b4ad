//! Activities: list, look, wait, abort.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::daemon::Daemon;
use crate::hosting::{Activity, Hosted};
use crate::rpc::components;
use crate::rpc::error::RpcError;
use crate::rpc::input::Parameters;

/// Longest time one request is held.
const LONGEST_WAIT: f64 = 3600.0;

/// `?wait=SECONDS`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LookParameters {
    /// Answer when the activity has ended, or after so many seconds.
    wait: Option<f64>,
}

/// `GET /components/{component}/activities`
pub(crate) async fn list(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let activities: Vec<_> = hosted
        .activities
        .all()
        .iter()
        .map(|activity| activity.to_json(hosted.state(activity.number).as_deref()))
        .collect();
    Ok(Json(json!({ "activities": activities })))
}

/// `GET /components/{component}/activities/{number}?wait=SECONDS`
pub(crate) async fn look(
    State(daemon): State<Arc<Daemon>>,
    Path((component, activity)): Path<(String, String)>,
    Parameters(parameters): Parameters<LookParameters>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let activity = find(&hosted, &activity)?;
    if let Some(seconds) = parameters.wait {
        let wait = Duration::try_from_secs_f64(seconds.min(LONGEST_WAIT)).map_err(|_| {
            RpcError::bad_input(format!("wait: {seconds} is no number of seconds")).place("wait")
        })?;
        // Not ended in time: the reply says that it runs.
        let _ = tokio::time::timeout(wait, activity.ended()).await;
    }
    Ok(Json(activity.to_json(hosted.state(activity.number).as_deref())))
}

/// `DELETE /components/{component}/activities/{number or service}`
pub(crate) async fn abort(
    State(daemon): State<Arc<Daemon>>,
    Path((component, which)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let chosen = match which.parse::<u64>() {
        Ok(_) => {
            let activity = find(&hosted, &which)?;
            if activity.ending().is_some() {
                let message = format!("activity {which} of {component} has already ended");
                return Err(RpcError::conflict("ended", message));
            }
            vec![activity]
        }
        Err(_) => of_service(&hosted, &which)?,
    };
    let aborted: Vec<u64> = chosen
        .iter()
        .filter(|activity| activity.ending().is_none() && hosted.abort(activity.number))
        .map(|activity| activity.number)
        .collect();
    Ok(Json(json!({ "aborted": aborted })))
}

fn find(hosted: &Hosted, number: &str) -> Result<Arc<Activity>, RpcError> {
    number.parse().ok().and_then(|number| hosted.activities.get(number)).ok_or_else(|| {
        let message = format!("{} has no activity `{number}`", hosted.name);
        RpcError::new(StatusCode::NOT_FOUND, "no_such_activity", message)
            .help("it never was, or it ended long ago: GET .../activities lists them")
    })
}

fn of_service(hosted: &Hosted, service: &str) -> Result<Vec<Arc<Activity>>, RpcError> {
    let services = &hosted.model().services;
    if !services.iter().any(|found| found.name == service) {
        let what = format!("{} has no activity or service", hosted.name);
        let names = services.iter().map(|service| service.name.as_str());
        return Err(RpcError::unknown("no_such_activity", what, service, names));
    }
    let all = hosted.activities.all();
    Ok(all.into_iter().filter(|activity| activity.service == service).collect())
}
