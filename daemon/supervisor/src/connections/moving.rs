//! Moves a running component, or one of its ports, to other middlewares.
//!
//! New ends are opened and filled first; exchanging them takes a few stores while codels are
//! excluded; old ends are closed after that. No codel notices, no tick is missed.

use std::collections::BTreeMap;
use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_description::model::PortIx;
use genom_middleware::{Address, EndpointKind, OpenError, PortSpec, Publisher, Subscription};
use genom_ports::{Fan, PortKey, Tap};
use genom_runtime::HeldUp;

use super::core::{Connections, Patience, Wanted};
use super::error::Kind;
use super::find::publishes;
use super::last::LastValue;
use super::opening::BindError;
use crate::bus::Change;
use crate::components::Hosted;
use crate::ties::{PortConnection, ServiceConnection};

/// What is to be exchanged for an out port.
struct NewEnds {
    key: PortKey,
    fan: Fan,
    opened: BTreeMap<String, Box<dyn Publisher>>,
    last: LastValue,
}

impl NewEnds {
    /// Late readers where it comes to see the last value at once.
    fn offer(&mut self, hosted: &Hosted) {
        let Some(value) = &self.last.value else { return };
        for (name, publisher) in &mut self.opened {
            if let Err(error) = publisher.publish(value) {
                let address = hosted.port_address(&self.key);
                tracing::debug!("{address}: the last value is not offered on {name}: {error}");
            }
        }
    }

    /// Exchanges the ends, with all codels excluded; those to be closed later.
    fn exchange(mut self, hosted: &Hosted, to: &BackendNames) -> Vec<(String, Box<dyn Publisher>)> {
        // A codel may have written since it was looked at.
        if !self.opened.is_empty() && self.last.renew(hosted, &self.key, &self.fan) {
            self.offer(hosted);
        }
        self.fan.exchange(|ends| {
            let mut all: BTreeMap<String, _> = ends.drain(..).collect();
            all.append(&mut self.opened);
            let kept = to.names().iter();
            *ends =
                kept.filter_map(|name| all.remove(name).map(|end| (name.clone(), end))).collect();
            all.into_iter().collect()
        })
    }
}

/// What is to be exchanged for a connection.
struct NewFeed {
    key: PortKey,
    tap: Tap,
    backend: String,
    end: Box<dyn Subscription>,
    reader: Arc<Hosted>,
}

impl NewFeed {
    fn exchange(self) -> Result<(), HeldUp> {
        let old = self.reader.excluded(|| self.tap.exchange(self.end))?;
        self.reader.ties.moved(&self.key, &self.backend);
        drop(old);
        Ok(())
    }

    /// Whether it can be exchanged.
    fn ready(&self) -> Result<(), HeldUp> {
        self.reader.excluded(|| ())
    }
}

impl Connections {
    /// Moves a component with all its ports and services, or one port when it is named.
    ///
    /// Connections of this daemon's components that read the moved out ports follow, unless their
    /// backend was asked for by name.
    ///
    /// # Errors
    /// A middleware refuses, or a codel does not return; nothing is changed then.
    pub fn move_to(
        &self,
        hosted: &Arc<Hosted>,
        port: Option<PortIx>,
        to: &BackendNames,
    ) -> Result<(), BindError> {
        let _turn = hosted.ties.bindings.turn();
        let mut ends = Vec::new();
        let mut feeds = self.own_feeds(hosted, port, to)?;
        for (key, fan) in hosted.ties.fans() {
            if port.is_some_and(|only| only != key.port) {
                continue;
            }
            ends.extend(self.new_ends(hosted, key.clone(), fan, to)?);
            feeds.extend(self.followers(&hosted.port_address(&key), to)?);
        }
        let served = match port {
            None => Some(self.serve_on(hosted, &added(&hosted.ties.bindings.component(), to))?),
            Some(_) => None,
        };
        // Before anything is exchanged.
        feeds.iter().try_for_each(NewFeed::ready)?;
        let old_ends: Vec<_> =
            hosted.excluded(|| ends.into_iter().map(|new| new.exchange(hosted, to)).collect())?;
        for new in feeds {
            if let Err(held_up) = new.exchange() {
                // A moment ago it was not: what it reads stands still.
                tracing::error!("a connection does not follow {}: {held_up}", hosted.name);
            }
        }
        drop(old_ends);
        match port {
            None => hosted.ties.bindings.move_component(to),
            Some(port) => hosted.ties.bindings.move_port(&hosted.model().ports[port].name, to),
        }
        if let Some(served) = served {
            hosted.serve_also(served, to);
        }
        self.bus.tell(&Change::BackendChanged {
            component: hosted.name.clone(),
            port: port.map(|port| hosted.model().ports[port].name.clone()),
            backend: to.to_string(),
        });
        Ok(())
    }

    /// The ends of an out port where it was not yet, with its last value.
    fn new_ends(
        &self,
        hosted: &Hosted,
        key: PortKey,
        fan: Fan,
        to: &BackendNames,
    ) -> Result<Option<NewEnds>, BindError> {
        let Some(ty) = hosted.port_type(key.port) else { return Ok(None) };
        let (address, quality) = (hosted.port_address(&key), hosted.quality(&key));
        let mut opened = BTreeMap::new();
        for name in added(&hosted.backends_of(&key), to) {
            let on = BackendNames::one(name);
            opened.extend(self.opening.ends(&on, &address, ty, quality)?);
        }
        let last = if opened.is_empty() {
            LastValue::default()
        } else {
            self.last_value(hosted, &key, &fan, ty)
        };
        let mut new = NewEnds { key, fan, opened, last };
        new.offer(hosted);
        Ok(Some(new))
    }

    /// Connections of this daemon that read `address`, opened anew where it goes.
    fn followers(&self, address: &Address, to: &BackendNames) -> Result<Vec<NewFeed>, BindError> {
        let mut all = Vec::new();
        for reader in self.components.all() {
            for (key, made, tap) in reader.ties.taps() {
                let stays = made.fixed || to.has(&made.backend);
                if made.outport == *address && !stays {
                    all.extend(self.new_feed(&reader, key, &made, tap, to.first())?);
                }
            }
        }
        Ok(all)
    }

    /// Connections of the component's own in ports to writers of other daemons: they move too when
    /// the writer is visible there. Writers of this daemon stay where they are, and so do
    /// connections to them. A writer that shows there later is followed by
    /// [`catch_up`](Self::catch_up).
    fn own_feeds(
        &self,
        hosted: &Arc<Hosted>,
        port: Option<PortIx>,
        to: &BackendNames,
    ) -> Result<Vec<NewFeed>, BindError> {
        let mut all = Vec::new();
        for (key, made, tap) in hosted.ties.taps() {
            let stays = made.fixed
                || to.has(&made.backend)
                || self.components.get(&made.outport.instance).is_some();
            if port.is_some_and(|only| only != key.port) || stays {
                continue;
            }
            if publishes(self.backends.get(to.first())?.as_ref(), &made.outport) {
                all.extend(self.new_feed(hosted, key, &made, tap, to.first())?);
            }
        }
        Ok(all)
    }

    /// A connection opened anew on another middleware.
    fn new_feed(
        &self,
        reader: &Arc<Hosted>,
        key: PortKey,
        made: &PortConnection,
        tap: Tap,
        on: &str,
    ) -> Result<Option<NewFeed>, BindError> {
        let Some(ty) = reader.port_type(key.port) else { return Ok(None) };
        let port = PortSpec::new(&made.outport, ty).of(reader.quality(&key));
        let end = self.backends.get(on)?.subscription(&port, made.policy).map_err(boxed)?;
        let (backend, reader) = (on.to_owned(), Arc::clone(reader));
        Ok(Some(NewFeed { key, tap, backend, end, reader }))
    }

    /// Moves connections to writers and services of other daemons that went where the in port or
    /// the caller is as well: moved after it, or not seen there yet when it moved.
    pub(super) fn catch_up(&self) {
        let mut seen = Seen::default();
        for reader in self.components.all() {
            self.follow_services(&reader, &mut seen);
            let _turn = reader.ties.bindings.turn();
            for (key, made, tap) in reader.ties.taps() {
                let PortConnection { inport, outport, backend, fixed, .. } = &made;
                if *fixed || self.components.get(&outport.instance).is_some() {
                    continue;
                }
                let ours = reader.backends_of(&key);
                let mut shows = |on: &str| seen.shows(self, on, EndpointKind::Publisher, outport);
                let Some(to) = elsewhere(&ours, backend, &mut shows) else { continue };
                let moved = match self.new_feed(&reader, key, &made, tap, to) {
                    Ok(Some(new)) => new.exchange().map_err(|held_up| held_up.to_string()),
                    Ok(None) => continue,
                    Err(error) => Err(error.to_string()),
                };
                match moved {
                    Ok(()) => tracing::info!("{inport} reads {outport} on {to} now"),
                    Err(why) => tracing::debug!("{outport} on {to}: {why}"),
                }
            }
        }
    }

    /// The same for the remotes of a component.
    fn follow_services(&self, caller: &Hosted, seen: &mut Seen) {
        let ours = caller.ties.bindings.component();
        for ServiceConnection { remote, service, backend, fixed } in caller.ties.services() {
            let Some(backend) = backend.filter(|_| !fixed) else { continue };
            let mut shows = |on: &str| seen.shows(self, on, EndpointKind::Service, &service);
            if elsewhere(&ours, &backend, &mut shows).is_none() {
                continue;
            }
            let wanted = Wanted {
                inport: remote.to_string(),
                kind: Some(Kind::Service),
                outport: service.to_string(),
                policy: None,
                backend: None,
                wait: false,
                patience: Patience::None,
            };
            match self.make(&wanted) {
                Ok(made) => {
                    let on = made.backend().unwrap_or_default();
                    tracing::info!("{remote} calls {service} on {on} now");
                }
                Err(error) => tracing::debug!("{remote}: {error}"),
            }
        }
    }
}

/// The middlewares among these that are not among those at present.
fn added(present: &BackendNames, to: &BackendNames) -> Vec<String> {
    to.names().iter().filter(|name| !present.has(name)).cloned().collect()
}

/// The first of our middlewares where the other side shows, when it does not where it was, or we
/// are not there any more.
fn elsewhere<'a>(
    ours: &'a BackendNames,
    present: &str,
    shows: &mut dyn FnMut(&str) -> bool,
) -> Option<&'a str> {
    let mut others = ours.names().iter().filter(|name| *name != present).peekable();
    others.peek()?;
    if ours.has(present) && shows(present) {
        return None;
    }
    others.find(|name| shows(name)).map(String::as_str)
}

/// What shows on each middleware, looked up once.
#[derive(Default)]
struct Seen(BTreeMap<String, BTreeMap<String, EndpointKind>>);

impl Seen {
    fn shows(
        &mut self,
        all: &Connections,
        backend: &str,
        kind: EndpointKind,
        at: &Address,
    ) -> bool {
        let visible = self.0.entry(backend.to_owned()).or_insert_with(|| {
            let found = all.backends.get(backend).ok().and_then(|on| on.discover().ok());
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
