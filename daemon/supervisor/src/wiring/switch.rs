//! Moves a running component, or one of its ports, to other middlewares.
//!
//! New ends are opened and filled first; exchanging them takes a few stores while codels are
//! excluded; old ends are closed after that. No codel notices, no tick is missed.

use std::collections::BTreeMap;
use std::sync::Arc;

use genom_middleware::{
    Address, EndpointKind, OpenError, PortSpec, Publisher, Quality, Subscription,
};
use genom_ports::{Fan, Key, Tap};
use genom_runtime::HeldUp;
use genom_types::Record;

use super::publish::{self, BindError};
use super::remote::{self, RemoteRequest};
use super::{connect, serve};
use crate::bus::Change;
use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::wires::{Connection, RemoteConnection};
use genom_configuration::BackendNames;

/// What is to be exchanged for an out port.
struct NewEnds {
    fan: Fan,
    names: BackendNames,
    opened: BTreeMap<String, Box<dyn Publisher>>,
}

/// What is to be exchanged for a connection.
struct NewFeed {
    key: Key,
    tap: Tap,
    backend: String,
    end: Box<dyn Subscription>,
    component: Option<Arc<Hosted>>,
}

impl NewFeed {
    /// Exchanges it at a reader: the one it names, else `hosted`.
    fn exchange(self, hosted: &Hosted) -> Result<(), HeldUp> {
        let reader = self.component.as_deref().unwrap_or(hosted);
        let old = reader.excluded(|| self.tap.exchange(self.end))?;
        reader.wires.moved(&self.key, &self.backend);
        drop(old);
        Ok(())
    }

    /// Whether it can be exchanged.
    fn ready(&self) -> Result<(), HeldUp> {
        self.component.as_ref().map_or(Ok(()), |reader| reader.excluded(|| ()))
    }
}

/// Moves a component with all its ports and services, or one port when it is named.
///
/// Connections of this daemon's components that read the moved out ports follow, unless their
/// backend was asked for by name. Nothing is changed when a middleware refuses.
pub fn switch(
    daemon: &Arc<Daemon>,
    hosted: &Arc<Hosted>,
    port: Option<usize>,
    to: &BackendNames,
) -> Result<(), BindError> {
    let _turn = hosted.wires.bindings.turn();
    let mut ends = Vec::new();
    let mut followers = Vec::new();
    for ((index, element), fan) in hosted.wires.fans() {
        if port.is_some_and(|only| only != index) {
            continue;
        }
        let name = &hosted.model().ports[index].name;
        let address = hosted.address(name, element.as_deref());
        let present = hosted.wires.bindings.port(name);
        let quality = hosted.wires.bindings.quality(name);
        let value = hosted.port_value(index, element.as_deref());
        let Some(ty) = hosted.port_type(index) else { continue };
        let mut opened = BTreeMap::new();
        for name in to.names().iter().filter(|name| !present.has(name)) {
            let one = BackendNames::one(name.as_str());
            let new = publish::open(daemon, &one, &address, ty, &quality)?;
            for (name, mut publisher) in new {
                // Late readers on the new middleware see the last value at once.
                let mut record = Record::new(ty);
                if let Some(value) = &value
                    && record.merge_json(value).is_ok()
                    && let Err(error) = publisher.publish(&record)
                {
                    tracing::debug!("{address}: the last value is not offered on {name}: {error}");
                }
                opened.insert(name, publisher);
            }
        }
        followers.extend(follow(daemon, &address, to)?);
        ends.push(NewEnds { fan, names: to.clone(), opened });
    }
    let own = own_feeds(daemon, hosted, port, to)?;
    let served = match port {
        None => Some(serve::serve_on(daemon, hosted, &added(hosted, to))?),
        Some(_) => None,
    };
    // Before anything is exchanged.
    followers.iter().try_for_each(NewFeed::ready)?;
    let mut old_ends = Vec::new();
    hosted.excluded(|| {
        for NewEnds { fan, names, mut opened } in ends {
            old_ends.push(fan.exchange(|ends| {
                let mut all: BTreeMap<String, _> = ends.drain(..).collect();
                all.append(&mut opened);
                *ends = names
                    .names()
                    .iter()
                    .filter_map(|name| all.remove(name).map(|end| (name.clone(), end)))
                    .collect();
                all.into_iter().collect()
            }));
        }
    })?;
    for new in own.into_iter().chain(followers) {
        if let Err(held_up) = new.exchange(hosted) {
            // A moment ago it was not: what it reads stands still.
            tracing::error!("a connection does not follow {}: {held_up}", hosted.name);
        }
    }
    drop(old_ends);
    match port {
        None => hosted.wires.bindings.move_component(to),
        Some(index) => hosted.wires.bindings.move_port(&hosted.model().ports[index].name, to),
    }
    if let Some(served) = served {
        hosted.serve_also(served, to);
    }
    let what = port.map(|index| hosted.model().ports[index].name.clone());
    daemon.bus.tell(&Change::BackendChanged {
        component: hosted.name.clone(),
        port: what,
        backend: to.to_string(),
    });
    Ok(())
}

/// The middlewares a component comes to, that it was not on.
fn added(hosted: &Hosted, to: &BackendNames) -> Vec<String> {
    let present = hosted.wires.bindings.component();
    to.names().iter().filter(|name| !present.has(name)).cloned().collect()
}

/// Connections of this daemon that read `address`, opened anew where it goes.
fn follow(
    daemon: &Arc<Daemon>,
    address: &Address,
    to: &BackendNames,
) -> Result<Vec<NewFeed>, BindError> {
    let mut all = Vec::new();
    for reader in daemon.components.all() {
        for (key, connection, tap) in reader.wires.taps() {
            let stays = connection.fixed || to.has(&connection.backend);
            if connection.outport != *address || stays {
                continue;
            }
            let Some(ty) = reader.port_type(key.0) else { continue };
            let middleware = daemon.backends.get(to.first())?;
            let quality = quality_of(&reader, key.0);
            let end =
                middleware.subscription(&PortSpec::new(address, ty).of(quality), connection.policy);
            let end = end.map_err(boxed)?;
            let component = Some(Arc::clone(&reader));
            all.push(NewFeed { key, tap, backend: to.first().to_owned(), end, component });
        }
    }
    Ok(all)
}

/// Connections of the component's own in ports to writers of other daemons: they move too when
/// the writer is visible there. Writers of this daemon stay where they are, and so do
/// connections to them. A writer that shows there later is followed by [`catch_up`].
fn own_feeds(
    daemon: &Arc<Daemon>,
    hosted: &Arc<Hosted>,
    port: Option<usize>,
    to: &BackendNames,
) -> Result<Vec<NewFeed>, BindError> {
    let mut all = Vec::new();
    for (key, connection, tap) in hosted.wires.taps() {
        let stays = connection.fixed
            || to.has(&connection.backend)
            || daemon.components.get(&connection.outport.instance).is_some();
        if port.is_some_and(|only| only != key.0) || stays {
            continue;
        }
        let Some(ty) = hosted.port_type(key.0) else { continue };
        let middleware = daemon.backends.get(to.first())?;
        if !connect::publishes(middleware.as_ref(), &connection.outport) {
            continue;
        }
        let (from, quality) = (&connection.outport, quality_of(hosted, key.0));
        let end = middleware.subscription(&PortSpec::new(from, ty).of(quality), connection.policy);
        let end = end.map_err(boxed)?;
        all.push(NewFeed { key, tap, backend: to.first().to_owned(), end, component: None });
    }
    Ok(all)
}

fn quality_of(hosted: &Hosted, port: usize) -> Quality {
    hosted.wires.bindings.quality(&hosted.model().ports[port].name)
}

/// Moves connections to writers and services of other daemons that went where the in port or the
/// caller is as well: moved after it, or not seen there yet when it moved.
pub fn catch_up(daemon: &Arc<Daemon>) {
    let mut seen = Seen::default();
    for reader in daemon.components.all() {
        follow_services(daemon, &reader, &mut seen);
        let _turn = reader.wires.bindings.turn();
        for (key, connection, tap) in reader.wires.taps() {
            let Connection { outport, backend, policy, fixed, .. } = connection;
            if fixed || daemon.components.get(&outport.instance).is_some() {
                continue;
            }
            let ours = reader.wires.bindings.port(&reader.model().ports[key.0].name);
            let mut others = ours.names().iter().filter(|name| **name != backend);
            if others.clone().next().is_none()
                || (ours.has(&backend) && seen.shows(daemon, &backend, PUBLISHER, &outport))
            {
                continue;
            }
            let Some(to) = others.find(|name| seen.shows(daemon, name, PUBLISHER, &outport)) else {
                continue;
            };
            let Some(ty) = reader.port_type(key.0) else { continue };
            let opened = daemon.backends.get(to).map_err(|error| error.to_string());
            let quality = quality_of(&reader, key.0);
            let end = opened.and_then(|middleware| {
                let end = middleware.subscription(&PortSpec::new(&outport, ty).of(quality), policy);
                end.map_err(|error| error.to_string())
            });
            match end {
                Ok(end) => {
                    let backend = to.clone();
                    let new = NewFeed { key, tap, backend, end, component: None };
                    match new.exchange(&reader) {
                        Ok(()) => {
                            tracing::info!("{} reads {outport} on {to} now", connection.inport)
                        }
                        Err(held_up) => tracing::debug!("{held_up}"),
                    }
                }
                Err(error) => tracing::debug!("{outport} on {to}: {error}"),
            }
        }
    }
}

/// The same for the remotes of a component.
fn follow_services(daemon: &Arc<Daemon>, caller: &Hosted, seen: &mut Seen) {
    let ours = caller.wires.bindings.component();
    for RemoteConnection { remote, service, backend, fixed } in caller.wires.remotes() {
        let Some(backend) = backend.filter(|_| !fixed) else { continue };
        let mut others = ours.names().iter().filter(|name| **name != backend);
        if others.clone().next().is_none()
            || (ours.has(&backend) && seen.shows(daemon, &backend, SERVICE, &service))
            || !others.any(|name| seen.shows(daemon, name, SERVICE, &service))
        {
            continue;
        }
        let (remote, service) = (remote.to_string(), service.to_string());
        let request = RemoteRequest {
            remote,
            service,
            backend: None,
            wait: false,
            patience: connect::Patience::None,
        };
        match remote::connect(daemon, &request) {
            Ok(RemoteConnection { remote, service, backend, .. }) => {
                tracing::info!("{remote} calls {service} on {} now", backend.unwrap_or_default());
            }
            Err(error) => tracing::debug!("{}: {error}", request.remote),
        }
    }
}

const PUBLISHER: EndpointKind = EndpointKind::Publisher;
const SERVICE: EndpointKind = EndpointKind::Service;

/// What shows on each middleware, looked up once.
#[derive(Default)]
struct Seen(BTreeMap<String, BTreeMap<String, EndpointKind>>);

impl Seen {
    fn shows(&mut self, daemon: &Daemon, backend: &str, kind: EndpointKind, at: &Address) -> bool {
        let visible = self.0.entry(backend.to_owned()).or_insert_with(|| {
            let found = daemon.backends.get(backend).ok().and_then(|on| on.discover().ok());
            let ends = found.into_iter().flatten();
            let ends = ends.filter(|found| found.kind != EndpointKind::Subscription);
            ends.map(|found| (found.address, found.kind)).collect()
        });
        visible.get(&at.to_string()) == Some(&kind)
    }
}

fn boxed(error: OpenError) -> BindError {
    BindError::from(Box::new(error))
}
