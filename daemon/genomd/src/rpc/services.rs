//! Services: describe, call, start.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_description::tools;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::daemon::Daemon;
use crate::hosting::{Answer, Ending, Hosted};
use crate::rpc::components;
use crate::rpc::error::RpcError;
use crate::rpc::input::{Body, Parameters};

/// `?wait=true`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CallParameters {
    /// Answer only when the activity has ended.
    #[serde(default)]
    wait: bool,
}

fn find(hosted: &Hosted, service: &str) -> Result<usize, RpcError> {
    let services = &hosted.model().services;
    services.iter().position(|found| found.name == service).ok_or_else(|| {
        let what = format!("{} has no service", hosted.name);
        let names = services.iter().map(|service| service.name.as_str());
        RpcError::unknown("no_such_service", what, service, names)
    })
}

/// `GET /components/{component}/services/{service}`
pub(crate) async fn describe(
    State(daemon): State<Arc<Daemon>>,
    Path((component, service)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &service)?;
    let mut component = tools::describe(hosted.specification(), hosted.model());
    Ok(Json(component["services"][index].take()))
}

/// `POST /components/{component}/services/{service}` with the inputs
///
/// An attribute or function answers 200 with its end. An activity answers 202 with its number
/// once it is accepted, or with `?wait=true` 200 with its end.
pub(crate) async fn call(
    State(daemon): State<Arc<Daemon>>,
    Path((component, service)): Path<(String, String)>,
    Parameters(parameters): Parameters<CallParameters>,
    Body(inputs): Body<Value>,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &service)?;
    let input = hosted.input(index, &inputs).map_err(|error| {
        RpcError::bad_input(error.to_string())
            .place(error.path.clone())
            .help(format!("`genomctl info {component} {service}` shows the inputs"))
    })?;
    let answer = hosted.request(index, input).await;
    match answer {
        Answer::Ended(ending) => refusal(&hosted, &service, &ending)
            .map_or_else(|| Ok((StatusCode::OK, Json(ending.to_json().into()))), Err),
        Answer::Accepted(activity) if parameters.wait => {
            activity.ended().await;
            Ok((StatusCode::OK, Json(activity.to_json(None))))
        }
        Answer::Accepted(activity) => {
            Ok((StatusCode::ACCEPTED, Json(json!({"activity": activity.number}))))
        }
        Answer::Gone => {
            Err(RpcError::conflict("stopping", format!("{component} stops: nothing was started")))
        }
    }
}

/// Exceptions by which a component refuses a request before anything runs.
fn refusal(hosted: &Hosted, service: &str, ending: &Ending) -> Option<RpcError> {
    let name = format!("{}/{service}", hosted.name);
    match ending.exception()? {
        "::genom::disallowed" => Some(
            RpcError::conflict("disallowed", format!("{name} is not allowed now"))
                .help(order(hosted, service)),
        ),
        "::genom::too_many_activities" => Some(
            RpcError::new(
                StatusCode::TOO_MANY_REQUESTS,
                "too_many_activities",
                format!("no room for one more activity in the task of {name}"),
            )
            .help(format!("`genomctl activities {}` lists those that run", hosted.name)),
        ),
        _ => None,
    }
}

/// The order that a service asks for (genom3.md 7.6).
fn order(hosted: &Hosted, service: &str) -> String {
    let services = &hosted.model().services;
    let Some(service) = services.iter().find(|found| found.name == service) else {
        return String::new();
    };
    let names = |indices: &[usize]| {
        let names: Vec<_> = indices.iter().map(|&index| services[index].name.as_str()).collect();
        names.join(", ")
    };
    match (service.after.is_empty(), service.before.is_empty()) {
        (false, _) => format!("it comes after {}", names(&service.after)),
        (true, _) => format!("it comes before {}", names(&service.before)),
    }
}
