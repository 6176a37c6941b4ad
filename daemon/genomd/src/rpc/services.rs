//! Services: describe, call, start.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::{Extension, Json};
use genom_description::model::{Ix as _, ServiceIx};
use genom_description_tools as tools;
use genom_doors::{Body, Holder, Parameters, RpcError};
use genom_protocol::{
    CallParameters, CallReply, Code, Inputs, Outcome, Right, Service, Started, routes,
};
use genom_supervisor::Supervisor;
use genom_supervisor::components::{Answer, Hosted, InputError, Rest};
use genom_views::held_up;
use serde_json::Value;

use crate::rpc::components;

fn find(hosted: &Hosted, service: &str) -> Result<ServiceIx, RpcError> {
    let services = &hosted.model().services;
    services.find(|found| found.name == service).ok_or_else(|| {
        let what = format!("{} has no service", hosted.name);
        let names = services.iter().map(|service| service.name.as_str());
        RpcError::unknown(Code::NoSuchService, what, service, names)
    })
}

/// Describe a service: parameters, documentation, defaults, codels, exceptions.
///
/// `input_schema` and `output_schema` are JSON Schemas of its inputs and outputs. Inputs of an
/// attribute have `current`, the present value, which they keep if left out. It is included for
/// clients that may call the attribute, unless codels exclude reading it now.
#[utoipa::path(
    get,
    path = "/components/{component}/services/{service}",
    tag = "services",
    responses((status = 200, body = Service), (status = 404))
)]
pub(crate) async fn describe(
    State(supervisor): State<Arc<Supervisor>>,
    Extension(holder): Extension<Holder>,
    Path((component, service)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let index = find(&hosted, &service)?;
    let current = match holder.may(Right::Call, "") {
        Ok(()) => {
            let hosted = Arc::clone(&hosted);
            let look = tokio::task::spawn_blocking(move || hosted.current(index));
            look.await.ok().flatten()
        }
        Err(_) => None,
    };
    let mut component = tools::describe(hosted.specification(), hosted.model());
    let mut described = component["services"][index.index()].take();
    described["served"] = hosted.served_on(index).into();
    for parameter in described["parameters"].as_array_mut().into_iter().flatten() {
        let value = parameter["name"].as_str().and_then(|name| current.as_ref()?.get(name));
        if let Some(value) = value {
            parameter["current"] = value.clone();
        }
    }
    let [input, output] = tools::service_schemas(hosted.specification(), hosted.model(), index);
    described["input_schema"] = input;
    described["output_schema"] = output;
    Ok(Json(described))
}

/// Call a service, or start an activity.
///
/// The body contains the inputs. Inputs of an attribute that are left out, also members of an
/// input, keep their present values. Those of a function or activity take their defaults; one
/// without a default is refused by name. An attribute or function replies 200 with its outcome,
/// `result` or `exception`. An activity replies 202 with its number when it is accepted, or with
/// `?wait=true` 200 with its outcome.
#[utoipa::path(
    post,
    path = "/components/{component}/services/{service}",
    tag = "services",
    params(CallParameters),
    request_body = Option<Inputs>,
    responses(
        (status = 200, body = Outcome), (status = 202, body = Started), (status = 404),
        (status = 409), (status = 422), (status = 429), (status = 503)
    )
)]
pub(crate) async fn call(
    State(supervisor): State<Arc<Supervisor>>,
    Extension(holder): Extension<Holder>,
    Path((component, service)): Path<(String, String)>,
    Parameters(parameters): Parameters<CallParameters>,
    Body(inputs): Body<Value>,
) -> Result<(StatusCode, Json<CallReply>), RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let index = find(&hosted, &service)?;
    // Standard services have the effect of other routes, and require the same rights.
    if hosted.model().services[index].standard {
        let right = routes::right_of_standard_service(&service);
        holder.may(right, format_args!("service {service}"))?;
    }
    let refused = |error: InputError| {
        let help = if error.missing {
            "give it; or take zeros for all that is left out: `--zero`, `?zero=true`".to_owned()
        } else {
            format!("`genomctl info {component} {service}` shows the inputs")
        };
        RpcError::bad_input(error.to_string()).inside(&error.path).help(help)
    };
    let rest = if parameters.zero { Rest::Zero } else { Rest::Kept };
    let asked = hosted.asked(index, &inputs, rest).map_err(refused)?;
    let answer = hosted.request(index, asked).await;
    match answer {
        Answer::Ended(outcome) => {
            let refused = outcome.exception().and_then(|name| refusal(&hosted, &service, name));
            refused
                .map_or_else(|| Ok((StatusCode::OK, Json(CallReply::Ended(outcome.into())))), Err)
        }
        Answer::Accepted(activity) if parameters.wait => {
            activity.ended().await;
            Ok((StatusCode::OK, Json(CallReply::Activity(activity.look(None)))))
        }
        Answer::Accepted(activity) => Ok((
            StatusCode::ACCEPTED,
            Json(CallReply::Started(Started { activity: activity.number })),
        )),
        Answer::Refused(error) => Err(refused(error)),
        Answer::HeldUp(error) => Err(held_up(&error)),
        Answer::Gone => Err(RpcError::conflict(
            Code::Stopping,
            format!("{component} stops: nothing was started"),
        )),
    }
}

/// Converts exceptions by which a component refuses a request before anything is executed.
fn refusal(hosted: &Hosted, service: &str, exception: &str) -> Option<RpcError> {
    let name = format!("{}/{service}", hosted.name);
    match exception {
        "::genom::disallowed" => Some(
            RpcError::conflict(Code::Disallowed, format!("{name} is not allowed now"))
                .help(order(hosted, service)),
        ),
        "::genom::too_many_activities" => Some(
            RpcError::new(
                StatusCode::TOO_MANY_REQUESTS,
                Code::TooManyActivities,
                format!("no room for one more activity in the task of {name}"),
            )
            .help(format!(
                "`genomctl activities {}` lists those that run; max_activities of the daemon's \
                 configuration is the limit",
                hosted.name
            )),
        ),
        _ => None,
    }
}

/// The order that a service requires (`before`, `after`; genom3.md 7.6).
fn order(hosted: &Hosted, service: &str) -> String {
    let services = &hosted.model().services;
    let Some(service) = services.iter().find(|found| found.name == service) else {
        return String::new();
    };
    let names = |indices: &[ServiceIx]| {
        let names: Vec<_> = indices.iter().map(|&index| services[index].name.as_str()).collect();
        names.join(", ")
    };
    match (service.after.is_empty(), service.before.is_empty()) {
        (false, _) => format!("it comes after {}", names(&service.after)),
        (true, _) => format!("it comes before {}", names(&service.before)),
    }
}

#[cfg(test)]
mod tests {
    use genom_description::{Options, read_text};
    use genom_protocol::STANDARD_SERVICES;

    #[test]
    fn every_service_that_each_component_has_is_in_the_table_of_rights() {
        let read = read_text("c.gen", "component c { function own(); };", &Options::default());
        let specification = read.specification;
        let component = specification.components.first().unwrap();
        let standard: Vec<_> =
            component.services.iter().filter(|service| service.standard).collect();
        assert_eq!(standard.len() + 1, component.services.len());
        for service in standard {
            let row = STANDARD_SERVICES.iter().any(|(name, _)| *name == service.name);
            assert!(row, "{} has no row", service.name);
        }
    }
}
