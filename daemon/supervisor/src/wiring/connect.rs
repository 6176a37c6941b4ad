//! Connecting in ports to out ports of this daemon or of others, and back.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_description::model::PortDirection;
use genom_middleware::{Address, EndpointKind, Middleware, OpenError, Policy, PortSpec};
use genom_nearest::suggest;
use genom_ports::{Tap, key};
use genom_protocol::address::NoAddress;
use genom_runtime::HeldUp;

use crate::bus::Change;
use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::wires::Connection;
use genom_configuration::place::{Place, PlaceError};
use genom_configuration::terms;
use genom_registry::BackendError;

/// On a network others become visible a while after they, or we, came up.
const NETWORK: Duration = Duration::from_secs(2);
/// Between two looks at a network.
pub(super) const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// How long to look on a network for what does not show there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// Not at all: somebody asks again.
    None,
    /// Until this daemon has been there for long enough to see all that is there. What comes up at
    /// this very moment is not waited for: a component asks, whose other requests wait meanwhile.
    Newcomer,
    /// As long as what comes up now may take to become visible: a person asks.
    Full,
}

impl Patience {
    /// Until when to look on this middleware.
    pub(super) fn end(self, daemon: &Daemon, middleware: &dyn Middleware) -> Instant {
        let now = Instant::now();
        let network = middleware.capabilities().cross_host;
        match self {
            Patience::Newcomer if network => {
                daemon.backends.open_since(middleware.name()).unwrap_or(now) + NETWORK
            }
            Patience::Full if network => now + NETWORK,
            _ => now,
        }
    }
}

/// A connection to make.
#[derive(Clone, Debug)]
pub struct ConnectRequest {
    /// `component/port` or `component/port/element`, of this daemon.
    pub inport: String,
    /// The same, of any daemon.
    pub outport: String,
    /// What the reader gets of the samples it has not read.
    pub policy: Policy,
    /// By default the out port's, when it is in this daemon; else that of the in port.
    pub backend: Option<String>,
    /// Connect to an out port that is not there yet.
    pub wait: bool,
    /// How long to look for it on a network.
    pub patience: Patience,
}

/// A connection could not be made; what was there before still is.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ConnectError {
    /// No such in port.
    #[error("no_such_inport: {message}")]
    NoSuchInport { message: String, help: String },
    /// No such out port.
    #[error("no_such_outport: {message}")]
    NoSuchOutport {
        message: String,
        help: String,
        /// It may come later.
        absent: bool,
    },
    /// The types differ.
    #[error("{inport} reads {ours}, {outport} carries {theirs}")]
    Type { inport: String, ours: String, outport: String, theirs: String },
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused.
    #[error(transparent)]
    Failed(Box<OpenError>),
    /// A codel of the reader does not return.
    #[error(transparent)]
    HeldUp(HeldUp),
}

/// An in port could not be bound; it has what it had.
#[derive(Debug, thiserror::Error)]
pub enum AttachError {
    /// The middleware refused.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A codel of the reader does not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

impl ConnectError {
    /// The way out.
    pub fn help(&self) -> Option<&str> {
        match self {
            ConnectError::NoSuchInport { help, .. } | ConnectError::NoSuchOutport { help, .. } => {
                Some(help)
            }
            ConnectError::Type { .. } => Some("make the two .gen types equal"),
            _ => None,
        }
    }

    fn inport(message: impl Into<String>, help: impl Into<String>) -> Self {
        ConnectError::NoSuchInport { message: message.into(), help: help.into() }
    }

    fn outport(message: impl Into<String>, help: impl Into<String>) -> Self {
        ConnectError::NoSuchOutport { message: message.into(), help: help.into(), absent: false }
    }
}

/// Makes a connection, in place of the one the in port had. Blocks while codels are excluded.
pub fn connect(daemon: &Arc<Daemon>, request: &ConnectRequest) -> Result<Connection, ConnectError> {
    let (hosted, port, element) = reader(daemon, &request.inport)?;
    let made = connect_port(daemon, request, &hosted, port, element.as_deref());
    if let Err(error @ ConnectError::Type { .. }) = &made {
        hosted.wires.refused(port, element.as_deref(), error.to_string());
    }
    made
}

fn connect_port(
    daemon: &Arc<Daemon>,
    request: &ConnectRequest,
    hosted: &Arc<Hosted>,
    port: usize,
    element: Option<&str>,
) -> Result<Connection, ConnectError> {
    let place = Place::parse(&request.outport).map_err(|error| match error {
        PlaceError::Backend(error) => ConnectError::Backend(error),
        error @ PlaceError::Form(_) => {
            ConnectError::outport(error.to_string(), "write for instance demo/position")
        }
    })?;
    if let (Some(one), Some(other)) = (&place.backend, &request.backend)
        && one != other
    {
        let message = format!("{} is on {one}, and {other} is asked for", request.outport);
        return Err(ConnectError::outport(message, "name one of the two"));
    }
    let outport = place.address;
    let asked = request.backend.clone().or(place.backend.clone());
    let local = daemon.components.get(&outport.instance);
    let backend = choose(daemon, asked.as_deref(), local.as_deref(), hosted, port, &outport);
    let middleware = daemon.backends.get(&backend)?;
    let inport = hosted.address(&hosted.model().ports[port].name, element);
    // From itself: somebody outside publishes there, or will.
    let from_outside = outport == inport;
    // A peer that is no genomd need not show itself where there are no announcements.
    let foreign = place.backend.is_some() && middleware.capabilities().cross_host;
    match &local {
        _ if from_outside => {}
        Some(writer) => check_local(writer, &outport, &backend, hosted, port, &inport)?,
        None if !request.wait && !foreign => {
            let end = request.patience.end(daemon, middleware.as_ref());
            check_remote(middleware.as_ref(), &outport, end)?;
        }
        None => {}
    }
    let made = hosted.wires.feeds.hold(|feeds| {
        let (outport, fixed) = (outport.clone(), asked.is_some());
        let source = Source { outport, policy: request.policy, fixed };
        let made = attach(daemon, hosted, port, element, &middleware, source)?;
        // What the daemon published there is over, also for who wants to publish there itself.
        feeds.remove(&key(port, element));
        Ok(made)
    });
    made.map_err(|error| match error {
        AttachError::Open(OpenError::TypeMismatch { ours, theirs, .. }) => {
            let (inport, outport) = (inport.to_string(), outport.to_string());
            ConnectError::Type { inport, ours, outport, theirs }
        }
        AttachError::Open(error) => ConnectError::Failed(Box::new(error)),
        AttachError::HeldUp(error) => ConnectError::HeldUp(error),
    })
}

/// Where an in port is to read.
pub(super) struct Source {
    pub(super) outport: Address,
    pub(super) policy: Policy,
    /// Whether the middleware was asked for by name.
    pub(super) fixed: bool,
}

/// Binds an in port to an out port that was checked, and tells it.
pub(super) fn attach(
    daemon: &Daemon,
    hosted: &Hosted,
    port: usize,
    element: Option<&str>,
    middleware: &Arc<dyn Middleware>,
    source: Source,
) -> Result<Connection, AttachError> {
    let Source { outport, policy, fixed } = source;
    let inport = hosted.address(&hosted.model().ports[port].name, element);
    let Some(ty) = hosted.port_type(port) else {
        let (backend, why) = (middleware.name().to_owned(), "it has no type".to_owned());
        return Err(OpenError::Failed { backend, address: inport, why }.into());
    };
    let quality = hosted.wires.bindings.quality(&hosted.model().ports[port].name);
    let subscription = middleware.subscription(&PortSpec::new(&outport, ty).of(quality), policy)?;
    let tap = Tap::new(subscription, &daemon.clock, ty);
    let backend = middleware.name().to_owned();
    let connection = Connection { inport: inport.clone(), outport, backend, policy, fixed };
    let had = hosted.wires.connected(port, element, connection.clone(), tap.clone());
    // Known before it is used: a recording that starts now finds it here or there.
    let reads = Some(&connection.outport);
    daemon.recordings.opened(&inport, PortDirection::In, reads, ty, tap.tapes());
    if let Err(held_up) = hosted.bind_in(port, element, Some(tap.subscription())) {
        hosted.wires.put_back(port, element, had);
        return Err(held_up.into());
    }
    daemon.bus.tell(&Change::Connected {
        inport: connection.inport.to_string(),
        outport: connection.outport.to_string(),
        backend: connection.backend.clone(),
        policy: terms::told_policy(connection.policy).to_string(),
    });
    Ok(connection)
}

/// The middleware of a connection: the one asked for; else one the writer is on, when it is in
/// this daemon, else one the in port is on: the first where the writer shows.
fn choose(
    daemon: &Daemon,
    asked: Option<&str>,
    writer: Option<&Hosted>,
    hosted: &Hosted,
    port: usize,
    outport: &Address,
) -> String {
    if let Some(asked) = asked {
        return asked.to_owned();
    }
    let ours = hosted.wires.bindings.port(&hosted.model().ports[port].name);
    if let Some(writer) = writer {
        let theirs = writer.wires.bindings.port(split(outport).0);
        let common = theirs.names().iter().find(|name| ours.has(name));
        return common.map_or(theirs.first(), String::as_str).to_owned();
    }
    let shows =
        |name: &&String| daemon.backends.get(name).is_ok_and(|on| publishes(on.as_ref(), outport));
    match ours.names() {
        [_] => ours.first().to_owned(),
        several => several.iter().find(shows).map_or(ours.first(), String::as_str).to_owned(),
    }
}

/// Whether somebody announces this out port on a middleware.
pub fn publishes(middleware: &dyn Middleware, outport: &Address) -> bool {
    let wanted = middleware.spelled(outport);
    middleware.discover().is_ok_and(|endpoints| {
        endpoints
            .iter()
            .any(|found| found.kind == EndpointKind::Publisher && found.address == wanted)
    })
}

/// Takes a connection away; whether there was one.
pub fn disconnect(
    daemon: &Daemon,
    hosted: &Hosted,
    port: usize,
    element: Option<&str>,
) -> Result<bool, HeldUp> {
    let was_connected = hosted.wires.feeds.hold(|feeds| {
        let Some(had) = hosted.wires.disconnected(port, element) else { return Ok(false) };
        if let Err(held_up) = hosted.bind_in(port, element, None) {
            hosted.wires.put_back(port, element, Some(had));
            return Err(held_up);
        }
        feeds.remove(&key(port, element));
        Ok(true)
    })?;
    if !was_connected {
        return Ok(false);
    }
    let address = hosted.address(&hosted.model().ports[port].name, element);
    daemon.bus.tell(&Change::Disconnected { inport: address.to_string() });
    Ok(true)
}

/// The in port that an address names: component, index, element.
pub fn reader(
    daemon: &Daemon,
    text: &str,
) -> Result<(Arc<Hosted>, usize, Option<String>), ConnectError> {
    let address: genom_protocol::Address = text.parse().map_err(|error: NoAddress| {
        ConnectError::inport(error.to_string(), "write for instance demo/parameter")
    })?;
    let Some(hosted) = daemon.components.get(&address.component) else {
        let components = daemon.components.all();
        let names = components.iter().map(|hosted| hosted.name.as_str());
        let message = format!("no component `{}` in this daemon", address.component);
        return Err(ConnectError::inport(message, suggest(&address.component, names)));
    };
    let (name, element) = (address.port.as_str(), address.element.as_deref());
    let ports = &hosted.model().ports;
    let found = ports.iter().position(|port| port.name == name);
    let Some(index) = found.filter(|&index| ports[index].direction == PortDirection::In) else {
        let message = match found {
            Some(_) => format!("{}/{name} is an out port", hosted.name),
            None => format!("{} has no port `{name}`", hosted.name),
        };
        let inports = ports.iter().filter(|port| port.direction == PortDirection::In);
        let help = suggest(name, inports.map(|port| port.name.as_str()));
        return Err(ConnectError::inport(message, help));
    };
    let help = match (ports[index].multiple, element) {
        (true, None) => "name an element: COMPONENT/PORT/ELEMENT",
        (false, Some(_)) => "it is a single port: name it without an element",
        _ => {
            let element = element.map(str::to_owned);
            return Ok((hosted, index, element));
        }
    };
    Err(ConnectError::inport(format!("`{text}` names no in port"), help))
}

/// Port and element of an address.
fn split(address: &Address) -> (&str, Option<&str>) {
    match address.name.split_once('/') {
        Some((port, element)) => (port, Some(element)),
        None => (&address.name, None),
    }
}

/// The writer is in this daemon: everything about it is known.
fn check_local(
    writer: &Hosted,
    outport: &Address,
    backend: &str,
    hosted: &Hosted,
    port: usize,
    inport: &Address,
) -> Result<(), ConnectError> {
    let (name, element) = split(outport);
    let ports = &writer.model().ports;
    let found = ports.iter().position(|port| port.name == name);
    let Some(index) = found.filter(|&index| ports[index].direction == PortDirection::Out) else {
        let message = match found {
            Some(index) => {
                format!("{}/{name} is an {} port", writer.name, ports[index].direction.as_str())
            }
            None => format!("{} has no port `{name}`", writer.name),
        };
        let outports = ports.iter().filter(|port| port.direction == PortDirection::Out);
        let help = suggest(name, outports.map(|port| port.name.as_str()));
        return Err(ConnectError::outport(message, help));
    };
    if ports[index].multiple != element.is_some() {
        let message = format!("{outport} names no out port");
        let help = "a multiple port is named with an element, a single one without";
        return Err(ConnectError::outport(message, help));
    }
    let backends = writer.wires.bindings.port(name);
    if !backends.has(backend) {
        let message = format!("{outport} is on {backends}, not on {backend}");
        let help = format!(
            "leave the backend out, or `genomctl backend {}/{name} {backends}+{backend}` adds it",
            writer.name
        );
        return Err(ConnectError::outport(message, help));
    }
    if let (Some(ours), Some(theirs)) = (hosted.port_type(port), writer.port_type(index))
        && !ours.same_as(theirs)
    {
        return Err(ConnectError::Type {
            inport: inport.to_string(),
            ours: ours.to_string(),
            outport: outport.to_string(),
            theirs: theirs.to_string(),
        });
    }
    Ok(())
}

/// The writer is elsewhere: it must be visible, unless the caller is ready to wait.
fn check_remote(
    middleware: &dyn Middleware,
    outport: &Address,
    end: Instant,
) -> Result<(), ConnectError> {
    let backend = middleware.name();
    if !middleware.capabilities().cross_process {
        let message = format!(
            "no component `{}` in this daemon, and {backend} reaches no other",
            outport.instance
        );
        return Err(ConnectError::outport(message, "load both on another backend"));
    }
    let wanted = middleware.spelled(outport);
    let visible = loop {
        let visible = publishers(middleware, outport)?;
        if visible.contains(&wanted) {
            return Ok(());
        }
        if Instant::now() >= end {
            break visible;
        }
        std::thread::park_timeout(LOOK_AGAIN);
    };
    let message = format!("nobody publishes {wanted} on {backend}");
    let help = format!(
        "{}; a writer that comes later is waited for with --wait",
        suggest(&wanted, visible.iter().map(String::as_str))
    );
    Err(ConnectError::NoSuchOutport { message, help, absent: true })
}

/// Addresses of the out ports visible now, in order.
fn publishers(
    middleware: &dyn Middleware,
    outport: &Address,
) -> Result<BTreeSet<String>, ConnectError> {
    let endpoints = middleware.discover().map_err(|error| {
        ConnectError::Failed(Box::new(OpenError::Failed {
            backend: error.backend,
            address: outport.clone(),
            why: error.why,
        }))
    })?;
    let publishers = endpoints.into_iter().filter(|found| found.kind == EndpointKind::Publisher);
    Ok(publishers.map(|found| found.address).collect())
}
