//! The connections of one component's ports and remotes, as state that `connections` changes.
//!
//! Codels keep their publishers and subscriptions; what these refer to is exchanged.

mod bindings;
mod connection;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use genom_description::model::{PortIx, RemoteIx};
use genom_middleware::Address;
use genom_ports::gauge::Gauge;
use genom_ports::tape::Tapes;
use genom_ports::{Fan, Feeds, PortKey, Tap};
use genom_registry::Masquerade;

pub use self::bindings::Bindings;
pub use self::connection::{Connection, PortConnection, ServiceConnection};

/// The connections of one component.
#[derive(Debug)]
pub struct Ties {
    /// Its middlewares.
    pub bindings: Bindings,
    state: Mutex<State>,
    /// The daemon's publishers at its in ports. If both are locked, this comes before `state`.
    pub feeds: Feeds,
}

#[derive(Debug, Default)]
struct State {
    ports: BTreeMap<PortKey, (PortConnection, Tap)>,
    services: BTreeMap<RemoteIx, ServiceConnection>,
    /// In ports whose last connection failed because the types differ, with both types.
    differed: BTreeMap<PortKey, String>,
    /// Foreign names of its types, kept as long as its ports are open.
    masquerades: Vec<Masquerade>,
    /// Open out ports, and elements of multiple ones that codels opened.
    opened: BTreeMap<PortKey, Fan>,
    /// Middlewares on which out ports are open only as long as connections need that.
    lent: BTreeMap<PortKey, Vec<String>>,
    /// Names of out ports, and of their elements, that are open in the component whose place this one
    /// takes: they are handed over.
    promised: BTreeSet<String>,
}

impl Ties {
    /// No connections.
    #[must_use]
    pub fn new(bindings: Bindings) -> Self {
        Self { bindings, state: Mutex::default(), feeds: Feeds::default() }
    }

    /// For a component that is to take the place of another one: these out ports are handed over.
    pub(crate) fn promise(&self, all: BTreeSet<String>) {
        self.with(|state| state.promised = all);
    }

    /// Whether this out port, or element of one, is to be handed over.
    pub(crate) fn is_promised(&self, name: &str) -> bool {
        self.with(|state| state.promised.contains(name))
    }

    /// All that was to be handed over was.
    pub(crate) fn is_handed_over(&self) {
        self.with(|state| state.promised.clear());
    }

    /// Keeps the foreign names of the component's types.
    pub(crate) fn wear(&self, masquerades: Vec<Masquerade>) {
        self.with(|state| state.masquerades = masquerades);
    }

    /// The connection of an in port.
    #[must_use]
    pub fn connection(&self, key: &PortKey) -> Option<PortConnection> {
        self.with(|state| state.ports.get(key).map(|(connection, _)| connection.clone()))
    }

    /// The out port that an in port reads, unless that is this address.
    pub(crate) fn reads_other(&self, key: &PortKey, own: &Address) -> Option<Address> {
        self.with(|state| {
            let (connection, _) = state.ports.get(key)?;
            (connection.outport != *own).then(|| connection.outport.clone())
        })
    }

    /// The connection of a remote, given by its index.
    #[must_use]
    pub fn remote(&self, remote: RemoteIx) -> Option<ServiceConnection> {
        self.with(|state| state.services.get(&remote).cloned())
    }

    /// All connections: those of in ports, then those of remotes.
    #[must_use]
    pub fn connections(&self) -> Vec<Connection> {
        self.with(|state| {
            let ports = state.ports.values().map(|(made, _)| Connection::Port(made.clone()));
            let services = state.services.values().cloned().map(Connection::Service);
            ports.chain(services).collect()
        })
    }

    /// The counters of a port.
    #[must_use]
    pub fn gauge(&self, key: &PortKey) -> Option<Arc<Gauge>> {
        self.with(|state| match (state.opened.get(key), state.ports.get(key)) {
            (Some(fan), _) => Some(Arc::clone(fan.gauge())),
            (None, Some((_, tap))) => Some(Arc::clone(tap.gauge())),
            (None, None) => None,
        })
    }

    /// Elements of a multiple port: opened ones (out) or connected ones (in).
    #[must_use]
    pub fn elements(&self, port: PortIx) -> Vec<String> {
        self.with(|state| {
            let keys = state.opened.keys().chain(state.ports.keys());
            let all: BTreeSet<String> =
                keys.filter(|key| key.port == port).filter_map(|key| key.element.clone()).collect();
            all.into_iter().collect()
        })
    }

    /// Where recordings of ports are attached, with the address that an in port reads.
    pub(crate) fn tapes(&self) -> Vec<(PortKey, Option<Address>, Arc<Tapes>)> {
        self.with(|state| {
            let written = state.opened.iter().map(|(key, fan)| (key, None, fan.tapes()));
            let read = state
                .ports
                .iter()
                .map(|(key, (made, tap))| (key, Some(made.outport.clone()), tap.tapes()));
            let all = written.chain(read);
            all.map(|(key, reads, tapes)| (key.clone(), reads, Arc::clone(tapes))).collect()
        })
    }

    /// The open out ports, with their publishers.
    pub(crate) fn fans(&self) -> Vec<(PortKey, Fan)> {
        self.with(|state| {
            state.opened.iter().map(|(key, fan)| (key.clone(), fan.clone())).collect()
        })
    }

    /// The connected in ports, with their subscriptions.
    pub(crate) fn taps(&self) -> Vec<(PortKey, PortConnection, Tap)> {
        self.with(|state| {
            let all = state.ports.iter();
            all.map(|(key, (made, tap))| (key.clone(), made.clone(), tap.clone())).collect()
        })
    }

    /// The connections of remotes.
    pub(crate) fn services(&self) -> Vec<ServiceConnection> {
        self.with(|state| state.services.values().cloned().collect())
    }

    /// Stores the connection of an in port. Returns the previous one.
    pub(crate) fn connected(
        &self,
        key: PortKey,
        connection: PortConnection,
        tap: Tap,
    ) -> Option<(PortConnection, Tap)> {
        self.with(|state| {
            state.differed.remove(&key);
            state.ports.insert(key, (connection, tap))
        })
    }

    /// Restores the previous connection of an in port.
    pub(crate) fn put_back(&self, key: PortKey, had: Option<(PortConnection, Tap)>) {
        self.with(|state| match had {
            Some(had) => drop(state.ports.insert(key, had)),
            None => drop(state.ports.remove(&key)),
        });
    }

    /// Stores that an in port could not be connected because the types differ.
    pub(crate) fn refused(&self, key: PortKey, why: String) {
        self.with(|state| state.differed.insert(key, why));
    }

    /// Both types, if the last connection requested failed because they differ.
    #[must_use]
    pub fn differed(&self, key: &PortKey) -> Option<String> {
        self.with(|state| state.differed.get(key).cloned())
    }

    /// Stores that a connection moved to another middleware.
    pub(crate) fn moved(&self, key: &PortKey, backend: &str) {
        self.with(|state| {
            if let Some((connection, _)) = state.ports.get_mut(key) {
                backend.clone_into(&mut connection.backend);
            }
        });
    }

    /// Removes and returns the connection of an in port.
    pub(crate) fn disconnected(&self, key: &PortKey) -> Option<(PortConnection, Tap)> {
        self.with(|state| state.ports.remove(key))
    }

    /// Drops everything, after the component stopped.
    pub(crate) fn close(&self) {
        let old = self.with(std::mem::take);
        // Dropped after the lock is released, so that nobody waits.
        drop(old);
        self.feeds.close_all();
    }

    /// Cuts off a component that did not stop: its addresses become free, and codels that return
    /// later write to nobody and read nothing.
    ///
    /// If a codel stays inside `write` or `read` of a port, that one is closed when it comes back.
    pub(crate) fn cut(&self) {
        let old = self.with(std::mem::take);
        for (key, fan) in &old.opened {
            if !fan.cut() {
                let (port, element) = (key.port, key.element().unwrap_or_default());
                tracing::warn!(
                    "a codel is within `write` of port {port} {element}: it stays open until that \
                     returns"
                );
            }
        }
        for (connection, tap) in old.ports.values() {
            if !tap.cut() {
                let at = &connection.inport;
                tracing::warn!(
                    "a codel is within `read` of {at}: it stays open until that returns"
                );
            }
        }
        drop(old);
        self.feeds.close_all();
    }

    /// Stores the connection of a remote.
    pub(crate) fn remote_connected(&self, remote: RemoteIx, connection: ServiceConnection) {
        self.with(|state| state.services.insert(remote, connection));
    }

    /// Removes and returns the connection of a remote.
    pub(crate) fn remote_disconnected(&self, remote: RemoteIx) -> Option<ServiceConnection> {
        self.with(|state| state.services.remove(&remote))
    }

    /// An out port, or an element of a multiple one, was opened; on these middlewares only as long
    /// as connections need that.
    pub(crate) fn opened(&self, key: PortKey, fan: Fan, lent: Vec<String>) {
        self.with(|state| {
            put_lent(state, &key, lent);
            state.opened.insert(key, fan);
        });
    }

    /// The publishers of an out port, if it is open.
    pub(crate) fn fan(&self, key: &PortKey) -> Option<Fan> {
        self.with(|state| state.opened.get(key).cloned())
    }

    /// Middlewares on which an out port is open only as long as connections need that.
    #[must_use]
    pub fn lent(&self, key: &PortKey) -> Vec<String> {
        self.with(|state| state.lent.get(key).cloned().unwrap_or_default())
    }

    /// The out ports that are on such middlewares.
    pub(crate) fn all_lent(&self) -> Vec<PortKey> {
        self.with(|state| state.lent.keys().cloned().collect())
    }

    /// Stores these middlewares.
    pub(crate) fn lend(&self, key: &PortKey, lent: Vec<String>) {
        self.with(|state| put_lent(state, key, lent));
    }

    /// A codel closed an element of a multiple out port: it is not visible any more.
    pub(crate) fn closed(&self, key: &PortKey) {
        let old = self.with(|state| {
            state.lent.remove(key);
            state.opened.remove(key)
        });
        // Dropped after the lock is released, so that nobody waits.
        drop(old);
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn put_lent(state: &mut State, key: &PortKey, lent: Vec<String>) {
    if lent.is_empty() {
        state.lent.remove(key);
    } else {
        state.lent.insert(key.clone(), lent);
    }
}
