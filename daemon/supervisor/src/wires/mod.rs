//! What ports and remotes of one component are tied to: its state, which `wiring` changes.
//!
//! Ends that codels hold stay theirs; what is behind them is exchanged.

pub mod bindings;
mod connection;
pub mod declared;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use genom_middleware::Address;
use genom_ports::gauge::Gauge;
use genom_ports::tape::Tapes;
use genom_ports::{Fan, Feeds, Key, Tap, key};

use self::bindings::Bindings;
pub use self::connection::{Connection, RemoteConnection};
pub use genom_ports::gauge;

/// The wires of one component, as far as supervisors see them.
#[derive(Debug)]
pub struct Wires {
    /// The middlewares it is on.
    pub bindings: Bindings,
    state: Mutex<State>,
    /// Publishers at in ports, for values from outside. Locked before `state`, never after.
    pub feeds: Feeds,
}

#[derive(Debug, Default)]
struct State {
    connections: BTreeMap<Key, (Connection, Tap)>,
    remotes: BTreeMap<usize, RemoteConnection>,
    /// In ports whose last connection was refused because types differ, with both types.
    differed: BTreeMap<Key, String>,
    /// Out ports, and the elements of multiple ones that codels opened.
    opened: BTreeMap<Key, Fan>,
}

impl Wires {
    /// No wire yet.
    pub fn new(bindings: Bindings) -> Self {
        Self { bindings, state: Mutex::default(), feeds: Feeds::default() }
    }

    /// What feeds a port.
    pub fn connection(&self, port: usize, element: Option<&str>) -> Option<Connection> {
        let key = key(port, element);
        self.with(|state| state.connections.get(&key).map(|(connection, _)| connection.clone()))
    }

    /// All connections, by port.
    pub fn connections(&self) -> Vec<Connection> {
        self.with(|state| {
            state.connections.values().map(|(connection, _)| connection.clone()).collect()
        })
    }

    /// The service behind a remote.
    pub fn remote(&self, remote: usize) -> Option<RemoteConnection> {
        self.with(|state| state.remotes.get(&remote).cloned())
    }

    /// All remotes that are connected, by remote.
    pub fn remotes(&self) -> Vec<RemoteConnection> {
        self.with(|state| state.remotes.values().cloned().collect())
    }

    /// What passed through a port, written or read.
    pub fn gauge(&self, port: usize, element: Option<&str>) -> Option<Arc<Gauge>> {
        let key = key(port, element);
        self.with(|state| match (state.opened.get(&key), state.connections.get(&key)) {
            (Some(fan), _) => Some(Arc::clone(fan.gauge())),
            (None, Some((_, tap))) => Some(Arc::clone(tap.gauge())),
            (None, None) => None,
        })
    }

    /// Elements of a multiple port: opened (out) or connected (in).
    pub fn elements(&self, port: usize) -> Vec<String> {
        self.with(|state| {
            let keys = state.opened.keys().chain(state.connections.keys());
            let all: BTreeSet<String> = keys
                .filter(|(index, _)| *index == port)
                .filter_map(|(_, element)| element.clone())
                .collect();
            all.into_iter().collect()
        })
    }

    /// Where ports are recorded, with the address that an in port reads.
    pub fn tapes(&self) -> Vec<(Key, Option<Address>, Arc<Tapes>)> {
        self.with(|state| {
            let written = state.opened.iter().map(|(key, fan)| (key, None, fan.tapes()));
            let read = state.connections.iter().map(|(key, (connection, tap))| {
                (key, Some(connection.outport.clone()), tap.tapes())
            });
            let all = written.chain(read);
            all.map(|(key, reads, tapes)| (key.clone(), reads, Arc::clone(tapes))).collect()
        })
    }

    /// The out ports with their publishers.
    pub fn fans(&self) -> Vec<(Key, Fan)> {
        self.with(|state| {
            state.opened.iter().map(|(key, fan)| (key.clone(), fan.clone())).collect()
        })
    }

    /// The connections with their subscriptions.
    pub fn taps(&self) -> Vec<(Key, Connection, Tap)> {
        self.with(|state| {
            let all = state.connections.iter();
            all.map(|(key, (connection, tap))| (key.clone(), connection.clone(), tap.clone()))
                .collect()
        })
    }

    /// An in port was connected; what it had before.
    pub fn connected(
        &self,
        port: usize,
        element: Option<&str>,
        connection: Connection,
        tap: Tap,
    ) -> Option<(Connection, Tap)> {
        let key = key(port, element);
        self.with(|state| {
            state.differed.remove(&key);
            state.connections.insert(key, (connection, tap))
        })
    }

    /// It was not, after all: it has what it had.
    pub fn put_back(&self, port: usize, element: Option<&str>, had: Option<(Connection, Tap)>) {
        let key = key(port, element);
        self.with(|state| match had {
            Some(had) => drop(state.connections.insert(key, had)),
            None => drop(state.connections.remove(&key)),
        });
    }

    /// An in port was not connected because the types differ.
    pub fn refused(&self, port: usize, element: Option<&str>, why: String) {
        self.with(|state| state.differed.insert(key(port, element), why));
    }

    /// Both types, when the last connection asked for was refused because they differ.
    pub fn differed(&self, port: usize, element: Option<&str>) -> Option<String> {
        let key = key(port, element);
        self.with(|state| state.differed.get(&key).cloned())
    }

    /// A connection moved to another middleware.
    pub fn moved(&self, key: &Key, backend: &str) {
        self.with(|state| {
            if let Some((connection, _)) = state.connections.get_mut(key) {
                backend.clone_into(&mut connection.backend);
            }
        });
    }

    /// An in port was disconnected; what it was connected to.
    pub fn disconnected(&self, port: usize, element: Option<&str>) -> Option<(Connection, Tap)> {
        let key = key(port, element);
        self.with(|state| state.connections.remove(&key))
    }

    /// Lets go of everything: the component stopped.
    pub fn close(&self) {
        let old = self.with(std::mem::take);
        // Closed without holding up those who look.
        drop(old);
        self.feeds.close_all();
    }

    /// Cuts off a component that did not stop: its addresses are free, and codels that return
    /// after all write to nobody and read nothing.
    ///
    /// No codel is waited for: an end that one is in at this moment stays, and its address too.
    pub fn cut(&self) {
        let old = self.with(std::mem::take);
        for ((port, element), fan) in &old.opened {
            if !fan.cut() {
                let element = element.as_deref().unwrap_or_default();
                tracing::warn!("a codel is within `write` of port {port} {element}: it stays open");
            }
        }
        old.connections.values().for_each(|(_, tap)| tap.cut());
        drop(old);
        self.feeds.close_all();
    }

    /// A remote was connected.
    pub fn remote_connected(&self, remote: usize, connection: RemoteConnection) {
        self.with(|state| state.remotes.insert(remote, connection));
    }

    /// A remote was disconnected; what it was connected to.
    pub fn remote_disconnected(&self, remote: usize) -> Option<RemoteConnection> {
        self.with(|state| state.remotes.remove(&remote))
    }

    /// An out port was opened, or a codel opened an element of a multiple one.
    pub fn opened(&self, port: usize, element: Option<&str>, fan: Fan) {
        self.with(|state| state.opened.insert(key(port, element), fan));
    }

    /// A codel closed an element of a multiple out port: it shows nowhere any more.
    pub fn closed(&self, port: usize, element: &str) {
        let old = self.with(|state| state.opened.remove(&key(port, Some(element))));
        // Closed without holding up those who look.
        drop(old);
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
