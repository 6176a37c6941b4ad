//! Components and ports by the names in a request.

use std::sync::Arc;

use genom_description::model::PortIx;
use genom_doors::RpcError;
use genom_ports::PortKey;
use genom_protocol::Code;
use genom_supervisor::components::{Components as Running, Hosted};

/// The running component of that name.
///
/// # Errors
/// There is none; the message names the one that was probably meant.
pub fn find(all: &Running, name: &str) -> Result<Arc<Hosted>, RpcError> {
    let components = all.all();
    match components.iter().find(|hosted| hosted.name == name) {
        Some(hosted) => Ok(Arc::clone(hosted)),
        None => Err(RpcError::unknown(
            Code::NoSuchComponent,
            "no component",
            name,
            components.iter().map(|hosted| hosted.name.as_str()),
        )),
    }
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
