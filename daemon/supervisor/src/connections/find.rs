//! Finds both sides of a connection by name: in ports and remotes in this daemon, out ports and
//! services wherever they are visible.

use std::collections::BTreeSet;
use std::sync::Arc;

use genom_configuration::place::{Place, PlaceError};
use genom_description::model::{PortDirection, RemoteIx};
use genom_middleware::{Address, DiscoverError, EndpointKind, Middleware, OpenError};
use genom_nearest::suggest;
use genom_ports::PortKey;
use genom_protocol::address::NoAddress;

use super::core::{Connections, Wanted};
use super::error::{ConnectError, Kind};
use crate::components::Hosted;

/// The receiving side of a connection.
pub(super) enum Inlet {
    /// An in port of a component.
    Port(Arc<Hosted>, PortKey),
    /// A remote of a component, by its index.
    Remote(Arc<Hosted>, RemoteIx),
}

/// The providing side of a connection.
pub(super) struct Outlet {
    pub(super) address: Address,
    /// The middleware that was requested.
    pub(super) asked: Option<String>,
    /// Whether the address itself names the middleware; the peer may then be a program other than
    /// genomd.
    pub(super) foreign: bool,
}

impl Connections {
    /// Finds the remote or, failing that, the in port of this name.
    pub(super) fn inlet(&self, name: &str, kind: Option<Kind>) -> Result<Inlet, ConnectError> {
        if kind != Some(Kind::Port) {
            match self.remote(name) {
                Err(error) if kind.is_some() => return Err(error),
                Err(_) => {}
                found => return found,
            }
        }
        self.inport(name)
    }

    fn remote(&self, name: &str) -> Result<Inlet, ConnectError> {
        let refuse = |help| {
            ConnectError::inport(Kind::Service, format!("there is no remote `{name}`"), help)
        };
        let write = || refuse("write COMPONENT/REMOTE".to_owned());
        let address: genom_protocol::Address = name.parse().map_err(|_| write())?;
        let wanted = address.name();
        let caller = self.components.get(&address.component).ok_or_else(|| {
            let all = self.components.all();
            refuse(suggest(&address.component, all.iter().map(|hosted| hosted.name.as_str())))
        })?;
        let remotes = &caller.model().remotes;
        match remotes.find(|remote| remote.name == wanted) {
            Some(rank) => Ok(Inlet::Remote(caller, rank)),
            None => {
                let names = remotes.iter().map(|remote| remote.name.as_str());
                Err(refuse(suggest(&wanted, names)))
            }
        }
    }

    fn inport(&self, text: &str) -> Result<Inlet, ConnectError> {
        let refuse = |message, help: String| ConnectError::inport(Kind::Port, message, help);
        let address: genom_protocol::Address = text.parse().map_err(|error: NoAddress| {
            refuse(error.to_string(), "write for instance demo/parameter".to_owned())
        })?;
        let Some(hosted) = self.components.get(&address.component) else {
            let components = self.components.all();
            let names = components.iter().map(|hosted| hosted.name.as_str());
            let message = format!("no component `{}` in this daemon", address.component);
            return Err(refuse(message, suggest(&address.component, names)));
        };
        let (name, element) = (address.port.as_str(), address.element.as_deref());
        let ports = &hosted.model().ports;
        let found = ports.find(|port| port.name == name);
        let Some(port) = found.filter(|&port| ports[port].direction == PortDirection::In) else {
            let message = match found {
                Some(_) => format!("{}/{name} is an out port", hosted.name),
                None => format!("{} has no port `{name}`", hosted.name),
            };
            let inports = ports.iter().filter(|port| port.direction == PortDirection::In);
            return Err(refuse(message, suggest(name, inports.map(|port| port.name.as_str()))));
        };
        let help = match (ports[port].multiple, element) {
            (true, None) => "name an element: COMPONENT/PORT/ELEMENT",
            (false, Some(_)) => "it is a single port: name it without an element",
            _ => {
                let key = PortKey::new(port, element);
                return Ok(Inlet::Port(hosted, key));
            }
        };
        Err(refuse(format!("`{text}` names no in port"), help.to_owned()))
    }
}

impl Wanted {
    /// The providing side, with the middleware requested.
    pub(super) fn outlet(&self, kind: Kind) -> Result<Outlet, ConnectError> {
        let place = Place::parse(&self.outport).map_err(|error| match (error, kind) {
            (PlaceError::Backend(error), _) => ConnectError::Backend(error),
            (error @ PlaceError::Form(_), Kind::Port) => {
                ConnectError::outport(kind, error.to_string(), "write for instance demo/position")
            }
            (PlaceError::Form(_), Kind::Service) => {
                self.no_service("", "write COMPONENT/SERVICE, or BACKEND:COMPONENT/SERVICE")
            }
        })?;
        if let (Some(one), Some(other)) = (&place.backend, &self.over)
            && one != other
        {
            return Err(match kind {
                Kind::Port => {
                    let message = format!("{} is on {one}, and {other} is asked for", self.outport);
                    ConnectError::outport(kind, message, "name one of the two")
                }
                Kind::Service => {
                    let help = format!("it is on {one}, and {other} is asked for: name one");
                    self.no_service("", help)
                }
            });
        }
        let (asked, foreign) = (self.over.clone(), place.backend.is_some());
        Ok(Outlet { address: place.address, asked: asked.or(place.backend), foreign })
    }

    /// The error for a service that does not exist at `place`.
    pub(super) fn no_service(&self, place: &str, help: impl Into<String>) -> ConnectError {
        let message = format!("there is no service `{}`{place}", self.outport);
        ConnectError::outport(Kind::Service, message, help)
    }
}

/// Splits an address into port and element.
pub(super) fn split(address: &Address) -> (&str, Option<&str>) {
    match address.name.split_once('/') {
        Some((port, element)) => (port, Some(element)),
        None => (&address.name, None),
    }
}

/// Whether an out port is visible on a middleware.
#[must_use]
pub fn publishes(middleware: &dyn Middleware, outport: &Address) -> bool {
    shows(middleware, EndpointKind::Publisher, outport)
}

/// Whether a service is visible on a middleware.
#[must_use]
pub fn serves(middleware: &dyn Middleware, service: &Address) -> bool {
    shows(middleware, EndpointKind::Service, service)
}

/// Whether an endpoint of that kind is visible at an address.
pub(super) fn shows(middleware: &dyn Middleware, kind: EndpointKind, at: &Address) -> bool {
    is_visible(middleware, kind, at).unwrap_or(false)
}

/// The same, with the reason if the middleware cannot tell. Asks for this address only: listing
/// everything for each of many connections would take a time that grows with their square.
pub(super) fn is_visible(
    middleware: &dyn Middleware,
    kind: EndpointKind,
    at: &Address,
) -> Result<bool, ConnectError> {
    let ends = middleware.ends_at(at).map_err(|error| unknown(error, at))?;
    Ok(ends.iter().any(|end| end.kind == kind))
}

/// Addresses of all visible endpoints of a kind, sorted, for messages that suggest one. `at` is used
/// in errors only.
pub(super) fn visible(
    middleware: &dyn Middleware,
    kind: EndpointKind,
    at: &Address,
) -> Result<BTreeSet<String>, ConnectError> {
    let endpoints = middleware.discover().map_err(|error| unknown(error, at))?;
    let ends = endpoints.into_iter().filter(|found| found.kind == kind);
    Ok(ends.map(|found| found.address).collect())
}

fn unknown(error: DiscoverError, at: &Address) -> ConnectError {
    OpenError::Failed { backend: error.backend, address: at.clone(), why: error.why }.into()
}
