//! Connects in ports to out ports of this daemon or of others.

use std::sync::Arc;
use std::time::Instant;

use genom_configuration::terms;
use genom_description::model::PortDirection;
use genom_middleware::{Address, EndpointKind, Middleware, OpenError, Policy, PortSpec};
use genom_nearest::suggest;
use genom_ports::{Need, PortKey, Tap};
use genom_runtime::HeldUp;
use genom_types::DataType;

use super::core::{Connections, LOOK_AGAIN, Wanted};
use super::elsewhere::SHARED;
use super::error::{ConnectError, Kind};
use super::find::{Outlet, is_visible, publishes, split, visible};
use crate::components::Hosted;
use crate::ties::PortConnection;
use genom_bus::Change;

/// Why an in port could not be bound. The previous connection is kept.
#[derive(Debug, thiserror::Error)]
pub(super) enum AttachError {
    /// The middleware reported an error.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A codel of the reader does not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

/// What an in port is to read.
pub(super) struct Source {
    pub(super) outport: Address,
    pub(super) policy: Policy,
    /// Whether the middleware was requested explicitly.
    pub(super) fixed: bool,
}

/// The error for two ports of different types.
fn differs(inport: &Address, ours: &str, outport: &Address, theirs: &str) -> ConnectError {
    let message = format!("{inport} reads {ours}, {outport} carries {theirs}");
    ConnectError::Type { message, help: Some("make the two .gen types equal") }
}

impl Connections {
    pub(super) fn connect_port(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        wanted: &Wanted,
    ) -> Result<PortConnection, ConnectError> {
        let made = self.connect_checked(hosted, key, wanted);
        if let Err(error @ ConnectError::Type { .. }) = &made {
            hosted.ties.refused(key.clone(), error.to_string());
        }
        made
    }

    fn connect_checked(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        wanted: &Wanted,
    ) -> Result<PortConnection, ConnectError> {
        let Outlet { address: outport, asked, foreign } = wanted.outlet(Kind::Port)?;
        let local = self.components.get(&outport.instance);
        let backend = self.choose(asked.as_deref(), local.as_deref(), hosted, key, &outport);
        let middleware = self.backends.get(&backend)?;
        let inport = hosted.port_address(key);
        // Connected to its own address: a program other than the component's peers publishes there,
        // or will.
        let from_outside = outport == inport;
        // On a network, programs other than genomd need not be visible before they are connected
        // to.
        let foreign = foreign && middleware.capabilities().cross_host;
        match &local {
            _ if from_outside => {}
            Some(writer) => check_local(writer, &outport, hosted, key)?,
            None if !wanted.wait && !foreign => {
                let end = wanted.patience.end(&self.backends, middleware.as_ref());
                self.check_remote(middleware.as_ref(), &outport, asked.is_some(), end)?;
            }
            None => {}
        }
        let need = asked.is_some() && !from_outside && !outport.instance.is_empty();
        let need = need.then(|| Need { outport: outport.clone(), over: backend });
        self.with_end(&inport, need, || {
            let made = hosted.ties.feeds.hold(|feeds| {
                let (outport, fixed) = (outport.clone(), asked.is_some());
                let policy = wanted.policy.unwrap_or_default();
                let source = Source { outport, policy, fixed };
                let made = self.attach(hosted, key, &middleware, source)?;
                // The daemon's own publisher at this port is closed, also to let another program
                // publish there.
                feeds.remove(key);
                Ok(made)
            });
            made.map_err(|error| match error {
                AttachError::Open(OpenError::TypeMismatch { ours, theirs, .. }) => {
                    differs(&inport, &ours, &outport, &theirs)
                }
                AttachError::Open(error) => error.into(),
                AttachError::HeldUp(error) => error.into(),
            })
        })
    }

    /// Binds an in port to an out port, after all checks, and reports the change.
    pub(super) fn attach(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        middleware: &Arc<dyn Middleware>,
        source: Source,
    ) -> Result<PortConnection, AttachError> {
        let Source { outport, policy, fixed } = source;
        let inport = hosted.port_address(key);
        let Some(ty) = hosted.port_type(key.port) else {
            let (backend, why) = (middleware.name().to_owned(), "it has no type".to_owned());
            return Err(OpenError::Failed { backend, address: inport, why }.into());
        };
        let port = PortSpec::new(&outport, ty).of(hosted.quality(key));
        let subscription = middleware.subscription(&port, policy)?;
        let tap = Tap::new(subscription, &self.opening.clock, ty);
        let backend = middleware.name().to_owned();
        let connection = PortConnection { inport: inport.clone(), outport, backend, policy, fixed };
        let had = hosted.ties.connected(key.clone(), connection.clone(), tap.clone());
        // Registered before it is used: a recording that starts now finds it in one place or the
        // other.
        let reads = Some(&connection.outport);
        self.opening.recordings.opened(&inport, PortDirection::In, reads, ty, tap.tapes());
        if let Err(held_up) = hosted.bind_in(key, Some(tap.subscription())) {
            hosted.ties.put_back(key.clone(), had);
            return Err(held_up.into());
        }
        self.bus.tell(&Change::Connected {
            inport: connection.inport.to_string(),
            outport: connection.outport.to_string(),
            backend: connection.backend.clone(),
            policy: terms::told_policy(connection.policy).to_string(),
        });
        Ok(connection)
    }

    /// Chooses the middleware of a connection: the one requested, else the writer's if it is in
    /// this daemon, else the first one of the in port on which the writer is visible.
    fn choose(
        &self,
        asked: Option<&str>,
        writer: Option<&Hosted>,
        hosted: &Hosted,
        key: &PortKey,
        outport: &Address,
    ) -> String {
        if let Some(asked) = asked {
            return asked.to_owned();
        }
        let ours = hosted.ties.bindings.port(&hosted.model().ports[key.port].name);
        if let Some(writer) = writer {
            let theirs = writer.ties.bindings.port(split(outport).0);
            let common = theirs.names().iter().find(|name| ours.has(name));
            return common.map_or(theirs.first(), String::as_str).to_owned();
        }
        let shows = |name: &&String| {
            self.backends.get(name).is_ok_and(|on| publishes(on.as_ref(), outport))
        };
        if self.elsewhere.holds(&outport.instance) {
            return ours.names().iter().find(shows).map_or(SHARED, String::as_str).to_owned();
        }
        match ours.names() {
            [_] => ours.first().to_owned(),
            several => several.iter().find(shows).map_or(ours.first(), String::as_str).to_owned(),
        }
    }

    /// Disconnects an in port. Returns whether it was connected.
    pub(super) fn disconnect_port(&self, hosted: &Hosted, key: &PortKey) -> Result<bool, HeldUp> {
        self.without_end(&hosted.port_address(key), || {
            hosted.ties.feeds.hold(|feeds| {
                let Some(had) = hosted.ties.disconnected(key) else { return Ok(false) };
                if let Err(held_up) = hosted.bind_in(key, None) {
                    hosted.ties.put_back(key.clone(), Some(had));
                    return Err(held_up);
                }
                feeds.remove(key);
                Ok(true)
            })
        })
    }

    /// Checks a writer elsewhere: it must be visible, unless the caller agreed to wait.
    fn check_remote(
        &self,
        middleware: &dyn Middleware,
        outport: &Address,
        asked: bool,
        end: Instant,
    ) -> Result<(), ConnectError> {
        let (kind, backend) = (Kind::Port, middleware.name());
        if !middleware.capabilities().cross_process {
            let message = format!(
                "no component `{}` in this daemon, and {backend} reaches no other",
                outport.instance
            );
            let help = "load both on another backend";
            return Err(ConnectError::outport(kind, message, help));
        }
        while !is_visible(middleware, EndpointKind::Publisher, outport)? {
            if Instant::now() < end {
                std::thread::park_timeout(LOOK_AGAIN);
                continue;
            }
            let wanted = middleware.spelled(outport);
            let on = if asked { self.where_else(backend, outport) } else { Vec::new() };
            if !on.is_empty() {
                let message = format!("{wanted} is on {}, not on {backend}", on.join("+"));
                let help = format!(
                    "another daemon has it: `genomctl backend {wanted} {}+{backend}` there opens it",
                    on.join("+")
                );
                return Err(ConnectError::NoSuchOutport { kind, message, help, absent: true });
            }
            let visible = visible(middleware, EndpointKind::Publisher, outport)?;
            let help = format!(
                "{}; a writer that comes later is waited for with --wait",
                suggest(&wanted, visible.iter().map(String::as_str))
            );
            let message = format!("nobody publishes {wanted} on {backend}");
            return Err(ConnectError::NoSuchOutport { kind, message, help, absent: true });
        }
        Ok(())
    }

    /// The other open middlewares on which a writer elsewhere is visible.
    fn where_else(&self, backend: &str, outport: &Address) -> Vec<String> {
        let known = genom_registry::known().iter().map(|known| known.name);
        let open = known.filter(|name| *name != backend).filter_map(|on| self.backends.opened(on));
        let shows = open.filter(|open| publishes(open.as_ref(), outport));
        shows.map(|open| open.name().to_owned()).collect()
    }
}

/// Checks a writer in this daemon, about which everything is known.
fn check_local(
    writer: &Hosted,
    outport: &Address,
    hosted: &Hosted,
    key: &PortKey,
) -> Result<(), ConnectError> {
    let refuse = |message, help: String| Err(ConnectError::outport(Kind::Port, message, help));
    let (name, element) = split(outport);
    let ports = &writer.model().ports;
    let found = ports.find(|port| port.name == name);
    let Some(port) = found.filter(|&port| ports[port].direction == PortDirection::Out) else {
        let message = match found {
            Some(port) => {
                format!("{}/{name} is an {} port", writer.name, ports[port].direction.as_str())
            }
            None => format!("{} has no port `{name}`", writer.name),
        };
        let outports = ports.iter().filter(|port| port.direction == PortDirection::Out);
        return refuse(message, suggest(name, outports.map(|port| port.name.as_str())));
    };
    if ports[port].multiple != element.is_some() {
        let help = "a multiple port is named with an element, a single one without";
        return refuse(format!("{outport} names no out port"), help.to_owned());
    }
    let types = hosted.port_type(key.port).zip(writer.port_type(port));
    match types.filter(|(ours, theirs): &(&DataType, &DataType)| !ours.same_as(theirs)) {
        Some((ours, theirs)) => {
            let (ours, theirs) = (ours.to_string(), theirs.to_string());
            Err(differs(&hosted.port_address(key), &ours, outport, &theirs))
        }
        None => Ok(()),
    }
}
