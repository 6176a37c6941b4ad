//! Components, their ports and activities, by the names in a request.

use std::sync::Arc;

use axum::http::StatusCode;
use genom_description::model::PortIx;
use genom_doors::RpcError;
use genom_ports::PortKey;
use genom_protocol::Code;
use genom_supervisor::components::{Activity, Components as Running, Hosted};

/// The running component of that name.
///
/// # Errors
/// There is none; the message names the one that was probably meant.
pub fn find(all: &Running, name: &str) -> Result<Arc<Hosted>, RpcError> {
    all.get(name).ok_or_else(|| unknown(all, name))
}

/// The component of that name, also while it is being stopped.
///
/// # Errors
/// As of [`find`].
pub fn find_until_closed(all: &Running, name: &str) -> Result<Arc<Hosted>, RpcError> {
    all.get_until_closed(name).ok_or_else(|| unknown(all, name))
}

fn unknown(all: &Running, name: &str) -> RpcError {
    let components = all.all();
    let names = components.iter().map(|hosted| hosted.name.as_str());
    RpcError::unknown(Code::NoSuchComponent, "no component", name, names)
}

/// The activity of that number, also one that ended lately.
///
/// # Errors
/// There is none.
pub fn find_activity(hosted: &Hosted, number: &str) -> Result<Arc<Activity>, RpcError> {
    number.parse().ok().and_then(|number| hosted.activities.get(number)).ok_or_else(|| {
        let message = format!("{} has no activity `{number}`", hosted.name);
        RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchActivity, message).help(format!(
            "it never was, or it ended long ago: `genomctl activities {}` lists them",
            hosted.name
        ))
    })
}

/// The activities of the service of that name.
///
/// # Errors
/// There is no such service.
pub fn activities_of(hosted: &Hosted, service: &str) -> Result<Vec<Arc<Activity>>, RpcError> {
    let services = &hosted.model().services;
    if !services.iter().any(|found| found.name == service) {
        let what = format!("{} has no activity or service", hosted.name);
        let names = services.iter().map(|service| service.name.as_str());
        return Err(RpcError::unknown(Code::NoSuchActivity, what, service, names));
    }
    let all = hosted.activities.all();
    Ok(all.into_iter().filter(|activity| activity.service == service).collect())
}

/// The port of that name.
///
/// # Errors
/// The component has none.
pub fn find_port(hosted: &Hosted, port: &str) -> Result<PortIx, RpcError> {
    let ports = &hosted.model().ports;
    ports.find(|found| found.name == port).ok_or_else(|| {
        let what = format!("{} has no port", hosted.name);
        let names = ports.iter().map(|port| port.name.as_str());
        RpcError::unknown(Code::NoSuchPort, what, port, names)
    })
}

/// The port of that name, or an element of it. A multiple port requires an element, a single one
/// allows none.
///
/// # Errors
/// The component has no such port, or an element is missing or too much.
pub fn key(hosted: &Hosted, port: &str, element: Option<String>) -> Result<PortKey, RpcError> {
    let rank = find_port(hosted, port)?;
    let port = &hosted.model().ports[rank];
    let message = match (port.multiple, &element) {
        (true, None) => {
            format!("{}/{} is a multiple port: name an element", hosted.name, port.name)
        }
        (false, Some(element)) => {
            format!("{}/{} has no element `{element}`: it is single", hosted.name, port.name)
        }
        _ => return Ok(PortKey { port: rank, element }),
    };
    Err(RpcError::bad_input(message).place("element"))
}
