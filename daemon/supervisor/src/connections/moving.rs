//! Moves a running component, or one of its ports, to other middlewares.
//!
//! First the new publishers and subscriptions are opened and given the last value. Then they
//! replace the old ones while codels are excluded, which takes only a few stores. Old ones are
//! closed last. Codels notice nothing, and no tick is missed.

use std::collections::BTreeMap;
use std::sync::Arc;

use genom_configuration::BackendNames;
use genom_description::model::PortIx;
use genom_middleware::{Address, EndpointKind, OpenError, PortSpec, Publisher, Subscription};
use genom_ports::{Ends, Fan, PortKey, Tap};
use genom_runtime::HeldUp;

use super::core::{Connections, Patience, Wanted};
use super::error::Kind;
use super::find::publishes;
use super::last::LastValue;
use super::opening::BindError;
use crate::components::Hosted;
use crate::ties::{PortConnection, ServiceConnection};
use genom_bus::Change;

/// The new publishers of an out port, not in use yet.
pub(super) struct NewEnds {
    key: PortKey,
    fan: Fan,
    opened: BTreeMap<String, Box<dyn Publisher>>,
    last: LastValue,
    /// All middlewares that it is to be on.
    to: BackendNames,
    /// Those of them on which it is only as long as connections need that.
    lent: Vec<String>,
}

impl NewEnds {
    /// Publishes the last value on the new middlewares, for readers that are there already or come
    /// later.
    fn offer(&mut self, hosted: &Hosted) {
        let Some(value) = &self.last.value else { return };
        for (name, publisher) in &mut self.opened {
            if let Err(error) = publisher.publish(value) {
                let address = hosted.port_address(&self.key);
                tracing::debug!("{address}: the last value is not offered on {name}: {error}");
            }
        }
    }

    /// Replaces the publishers, with all codels excluded. Returns the old ones, to be dropped
    /// later.
    pub(super) fn exchange(mut self, hosted: &Hosted) -> Ends {
        // A codel may have written since the last value was read.
        if !self.opened.is_empty() && self.last.renew(hosted, &self.key, &self.fan) {
            self.offer(hosted);
        }
        hosted.ties.lend(&self.key, self.lent);
        self.fan.exchange(|ends| {
            let mut all: BTreeMap<String, _> = ends.drain(..).collect();
            all.append(&mut self.opened);
            let kept = self.to.names().iter();
            *ends =
                kept.filter_map(|name| all.remove(name).map(|end| (name.clone(), end))).collect();
            all.into_iter().collect()
        })
    }
}

/// The new subscription of an in port, not in use yet.
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

    /// Whether the reader's codels can be excluded now.
    fn ready(&self) -> Result<(), HeldUp> {
        self.reader.excluded(|| ())
    }
}

impl Connections {
    /// Moves a component with all its ports and services, or a single port.
    ///
    /// Connections of this daemon's components that read the moved out ports follow, unless their
    /// middleware was requested explicitly.
    ///
    /// # Errors
    /// A middleware reports an error, or a codel does not return. Nothing is changed then.
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
            let address = hosted.port_address(&key);
            // What connections need stays.
            let (mut lent, present) = (self.opening.needs.of(&address), hosted.backends_of(&key));
            lent.retain(|name| present.has(name) && !to.has(name));
            ends.extend(self.new_ends(hosted, key, fan, to, lent)?);
            feeds.extend(self.followers(&address, to)?);
        }
        let served = match port {
            None => Some(self.serve_on(hosted, &added(&hosted.ties.bindings.component(), to))?),
            Some(_) => None,
        };
        // Checked before anything is replaced.
        feeds.iter().try_for_each(NewFeed::ready)?;
        let old_ends: Vec<_> =
            hosted.excluded(|| ends.into_iter().map(|new| new.exchange(hosted)).collect())?;
        for new in feeds {
            if let Err(held_up) = new.exchange() {
                // The check above passed, but now a codel does not return: this reader gets no more
                // samples.
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

    /// New publishers for the middlewares that the out port is not on yet, with its last value: it is
    /// to be on those of `own`, and on those of `lent` as long as connections need that.
    pub(super) fn new_ends(
        &self,
        hosted: &Hosted,
        key: PortKey,
        fan: Fan,
        own: &BackendNames,
        lent: Vec<String>,
    ) -> Result<Option<NewEnds>, BindError> {
        let Some(ty) = hosted.port_type(key.port) else { return Ok(None) };
        let (address, quality) = (hosted.port_address(&key), hosted.quality(&key));
        let (mut opened, to) = (BTreeMap::new(), own.clone().with(&lent));
        for name in added(&hosted.backends_of(&key), &to) {
            let on = BackendNames::one(name);
            opened.extend(self.opening.ends(&on, &address, ty, quality)?);
        }
        let last = if opened.is_empty() {
            LastValue::default()
        } else {
            self.last_value(hosted, &key, &fan, ty)
        };
        let mut new = NewEnds { key, fan, opened, last, to, lent };
        new.offer(hosted);
        Ok(Some(new))
    }

    /// New subscriptions, on the port's new middlewares, for connections of this daemon that read
    /// `address`.
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

    /// New subscriptions for connections of the component's own in ports to writers of other
    /// daemons, if the writer is visible on the new middleware. Connections to writers in this
    /// daemon stay where the writer is. Writers that become visible later are handled by
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

    /// A new subscription, on another middleware, for an existing connection.
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

    /// Moves connections to writers and services of other daemons that have moved to another
    /// middleware of the in port or caller, or were not yet visible there when the in port or
    /// caller moved.
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
                over: None,
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

/// The middlewares of `to` that are not in `present`.
fn added(present: &BackendNames, to: &BackendNames) -> Vec<String> {
    to.names().iter().filter(|name| !present.has(name)).cloned().collect()
}

/// The first of our middlewares on which the other side is visible, if it is not visible on the
/// present one or we left that one.
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

/// Endpoints visible on each middleware; listed once.
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
