//! What the ports and remotes of one component are tied to: its state, which `connections` changes.
//!
//! Ends that codels hold stay theirs; what is behind them is exchanged.

mod bindings;
mod connection;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use genom_description::model::PortIx;
use genom_middleware::Address;
use genom_ports::gauge::Gauge;
use genom_ports::tape::Tapes;
use genom_ports::{Fan, Feeds, PortKey, Tap};
use genom_registry::Masquerade;

pub use self::bindings::Bindings;
pub use self::connection::{Connection, PortConnection, ServiceConnection};

/// What one component is tied to.
#[derive(Debug)]
pub struct Ties {
    /// The middlewares it is on.
    pub bindings: Bindings,
    state: Mutex<State>,
    /// Publishers at in ports, for values from outside. Locked before `state`, never after.
    pub feeds: Feeds,
}

#[derive(Debug, Default)]
struct State {
    ports: BTreeMap<PortKey, (PortConnection, Tap)>,
    services: BTreeMap<usize, ServiceConnection>,
    /// In ports whose last connection was refused because types differ, with both types.
    differed: BTreeMap<PortKey, String>,
    /// Foreign names of its types, as long as its ends are there.
    masquerades: Vec<Masquerade>,
    /// Out ports, and the elements of multiple ones that codels opened.
    opened: BTreeMap<PortKey, Fan>,
}

impl Ties {
    /// Tied to nothing yet.
    #[must_use]
    pub fn new(bindings: Bindings) -> Self {
        Self { bindings, state: Mutex::default(), feeds: Feeds::default() }
    }

    /// Its types go under these foreign names.
    pub(crate) fn wear(&self, masquerades: Vec<Masquerade>) {
        self.with(|state| state.masquerades = masquerades);
    }

    /// What feeds an in port.
    #[must_use]
    pub fn connection(&self, key: &PortKey) -> Option<PortConnection> {
        self.with(|state| state.ports.get(key).map(|(connection, _)| connection.clone()))
    }

    /// The service behind a remote, by the remote's rank.
    #[must_use]
    pub fn remote(&self, remote: usize) -> Option<ServiceConnection> {
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

    /// What passed through a port, written or read.
    #[must_use]
    pub fn gauge(&self, key: &PortKey) -> Option<Arc<Gauge>> {
        self.with(|state| match (state.opened.get(key), state.ports.get(key)) {
            (Some(fan), _) => Some(Arc::clone(fan.gauge())),
            (None, Some((_, tap))) => Some(Arc::clone(tap.gauge())),
            (None, None) => None,
        })
    }

    /// Elements of a multiple port: opened (out) or connected (in).
    #[must_use]
    pub fn elements(&self, port: PortIx) -> Vec<String> {
        self.with(|state| {
            let keys = state.opened.keys().chain(state.ports.keys());
            let all: BTreeSet<String> =
                keys.filter(|key| key.port == port).filter_map(|key| key.element.clone()).collect();
            all.into_iter().collect()
        })
    }

    /// Where ports are recorded, with the address that an in port reads.
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

    /// The out ports with their publishers.
    pub(crate) fn fans(&self) -> Vec<(PortKey, Fan)> {
        self.with(|state| {
            state.opened.iter().map(|(key, fan)| (key.clone(), fan.clone())).collect()
        })
    }

    /// The in ports that are connected, with their subscriptions.
    pub(crate) fn taps(&self) -> Vec<(PortKey, PortConnection, Tap)> {
        self.with(|state| {
            let all = state.ports.iter();
            all.map(|(key, (made, tap))| (key.clone(), made.clone(), tap.clone())).collect()
        })
    }

    /// The remotes that are connected.
    pub(crate) fn services(&self) -> Vec<ServiceConnection> {
        self.with(|state| state.services.values().cloned().collect())
    }

    /// An in port was connected; what it had before.
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

    /// It was not, after all: it has what it had.
    pub(crate) fn put_back(&self, key: PortKey, had: Option<(PortConnection, Tap)>) {
        self.with(|state| match had {
            Some(had) => drop(state.ports.insert(key, had)),
            None => drop(state.ports.remove(&key)),
        });
    }

    /// An in port was not connected because the types differ.
    pub(crate) fn refused(&self, key: PortKey, why: String) {
        self.with(|state| state.differed.insert(key, why));
    }

    /// Both types, when the last connection asked for was refused because they differ.
    #[must_use]
    pub fn differed(&self, key: &PortKey) -> Option<String> {
        self.with(|state| state.differed.get(key).cloned())
    }

    /// A connection moved to another middleware.
    pub(crate) fn moved(&self, key: &PortKey, backend: &str) {
        self.with(|state| {
            if let Some((connection, _)) = state.ports.get_mut(key) {
                backend.clone_into(&mut connection.backend);
            }
        });
    }

    /// An in port was disconnected; what it was connected to.
    pub(crate) fn disconnected(&self, key: &PortKey) -> Option<(PortConnection, Tap)> {
        self.with(|state| state.ports.remove(key))
    }

    /// Lets go of everything: the component stopped.
    pub(crate) fn close(&self) {
        let old = self.with(std::mem::take);
        // Closed without holding up those who look.
        drop(old);
        self.feeds.close_all();
    }

    /// Cuts off a component that did not stop: its addresses are free, and codels that return
    /// after all write to nobody and read nothing.
    ///
    /// No codel is waited for: an end that one is in at this moment stays, and its address too.
    pub(crate) fn cut(&self) {
        let old = self.with(std::mem::take);
        for (key, fan) in &old.opened {
            if !fan.cut() {
                let (port, element) = (key.port, key.element().unwrap_or_default());
                tracing::warn!("a codel is within `write` of port {port} {element}: it stays open");
            }
        }
        old.ports.values().for_each(|(_, tap)| tap.cut());
        drop(old);
        self.feeds.close_all();
    }

    /// A remote was connected.
    pub(crate) fn remote_connected(&self, remote: usize, connection: ServiceConnection) {
        self.with(|state| state.services.insert(remote, connection));
    }

    /// A remote was disconnected; what it was connected to.
    pub(crate) fn remote_disconnected(&self, remote: usize) -> Option<ServiceConnection> {
        self.with(|state| state.services.remove(&remote))
    }

    /// An out port was opened, or a codel opened an element of a multiple one.
    pub(crate) fn opened(&self, key: PortKey, fan: Fan) {
        self.with(|state| state.opened.insert(key, fan));
    }

    /// A codel closed an element of a multiple out port: it shows nowhere any more.
    pub(crate) fn closed(&self, key: &PortKey) {
        let old = self.with(|state| state.opened.remove(key));
        // Closed without holding up those who look.
        drop(old);
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
