//! What ports and services are tied to: bindings to middlewares, connections between ports.

pub(crate) mod connect;
pub(crate) mod feed;
pub(crate) mod policy;
pub(crate) mod publish;
pub(crate) mod remote;
pub(crate) mod requests;
pub(crate) mod serve;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use genom_middleware::{Address, Policy};

pub(crate) use connect::{ConnectError, ConnectRequest};

/// What feeds an in port.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    pub(crate) inport: Address,
    pub(crate) outport: Address,
    pub(crate) backend: String,
    pub(crate) policy: Policy,
}

/// The service behind a remote.
#[derive(Clone, Debug)]
pub(crate) struct RemoteConnection {
    pub(crate) remote: Address,
    pub(crate) service: Address,
}

/// A port by its index, or an element of a multiple one.
type Key = (usize, Option<String>);

/// The wires of one component, as far as supervisors see them.
#[derive(Debug, Default)]
pub(crate) struct Wires {
    state: Mutex<State>,
    /// Publishers at in ports, for values from outside. Locked before `state`, never after.
    pub(crate) feeds: feed::Feeds,
}

#[derive(Debug, Default)]
struct State {
    connections: BTreeMap<Key, Connection>,
    remotes: BTreeMap<usize, RemoteConnection>,
    /// Elements of multiple out ports that codels opened.
    opened: BTreeSet<(usize, String)>,
}

impl Wires {
    /// What feeds a port.
    pub(crate) fn connection(&self, port: usize, element: Option<&str>) -> Option<Connection> {
        let key = (port, element.map(str::to_owned));
        self.with(|state| state.connections.get(&key).cloned())
    }

    /// All connections, by port.
    pub(crate) fn connections(&self) -> Vec<Connection> {
        self.with(|state| state.connections.values().cloned().collect())
    }

    /// All remotes that are connected, by remote.
    pub(crate) fn remotes(&self) -> Vec<RemoteConnection> {
        self.with(|state| state.remotes.values().cloned().collect())
    }

    /// Elements of a multiple port: opened (out) or connected (in).
    pub(crate) fn elements(&self, port: usize) -> Vec<String> {
        self.with(|state| {
            let opened = state.opened.iter().filter(|(index, _)| *index == port);
            let connected = state.connections.keys().filter(|(index, _)| *index == port);
            let all: BTreeSet<String> = opened
                .map(|(_, element)| element.clone())
                .chain(connected.filter_map(|(_, element)| element.clone()))
                .collect();
            all.into_iter().collect()
        })
    }

    /// An in port was connected.
    fn connected(&self, port: usize, element: Option<&str>, connection: Connection) {
        let key = (port, element.map(str::to_owned));
        self.with(|state| state.connections.insert(key, connection));
    }

    /// An in port was disconnected; whether it was connected.
    fn disconnected(&self, port: usize, element: Option<&str>) -> bool {
        let key = (port, element.map(str::to_owned));
        self.with(|state| state.connections.remove(&key).is_some())
    }

    /// A remote was connected.
    fn remote_connected(&self, remote: usize, connection: RemoteConnection) {
        self.with(|state| state.remotes.insert(remote, connection));
    }

    /// A remote was disconnected; whether it was connected.
    fn remote_disconnected(&self, remote: usize) -> bool {
        self.with(|state| state.remotes.remove(&remote).is_some())
    }

    /// A codel opened an element of a multiple out port.
    fn opened(&self, port: usize, element: &str) {
        self.with(|state| state.opened.insert((port, element.to_owned())));
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
