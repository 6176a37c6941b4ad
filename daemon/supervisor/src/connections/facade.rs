//! Connections by name, whatever they are of: the one way to make one or to take it away.

use genom_configuration::ConnectionEntry;

use super::core::{Connections, Wanted};
use super::error::ConnectError;
use super::find::Inlet;
use crate::bus::Change;
use crate::ties::Connection;

impl Connections {
    /// Makes a connection that somebody asks for, in place of the one that is there: what a
    /// deployment declared for this in port or remote holds no more. Blocks while codels are
    /// excluded.
    ///
    /// # Errors
    /// It could not be made; what was there before still is.
    pub fn connect(&self, wanted: &Wanted) -> Result<Connection, ConnectError> {
        let made = self.make(wanted)?;
        self.declared.forget(&wanted.inport);
        Ok(made)
    }

    /// The same for a deployment, which declares what it makes.
    pub(crate) fn make(&self, wanted: &Wanted) -> Result<Connection, ConnectError> {
        match self.inlet(&wanted.inport, wanted.kind)? {
            Inlet::Remote(caller, remote) => {
                if wanted.policy.is_some() {
                    return Err(ConnectError::Policy { remote: wanted.inport.clone() });
                }
                self.connect_service(&caller, remote, wanted).map(Connection::Service)
            }
            Inlet::Port(hosted, key) => {
                self.connect_port(&hosted, &key, wanted).map(Connection::Port)
            }
        }
    }

    /// Takes the connection of an in port or remote away, and what a deployment declared for it;
    /// whether there was one. Blocks while codels are excluded.
    ///
    /// # Errors
    /// There is no such in port or remote, or a codel of its component does not return.
    pub fn disconnect(&self, inport: &str) -> Result<bool, ConnectError> {
        // Before: it would be made again.
        self.declared.forget(inport);
        self.take_away(inport)
    }

    /// The same, and what was declared for it stays.
    pub(crate) fn take_away(&self, inport: &str) -> Result<bool, ConnectError> {
        let (was_there, told) = match self.inlet(inport, None)? {
            Inlet::Remote(caller, remote) => {
                let inport = caller.address(&caller.model().remotes[remote].name, None);
                let told = Change::RemoteDisconnected { remote: inport.to_string() };
                (self.disconnect_service(&caller, remote)?, told)
            }
            Inlet::Port(hosted, key) => {
                let inport = hosted.port_address(&key).to_string();
                (self.disconnect_port(&hosted, &key)?, Change::Disconnected { inport })
            }
        };
        if was_there {
            self.bus.tell(&told);
        }
        Ok(was_there)
    }

    /// What feeds an in port, or serves a remote, now.
    #[must_use]
    pub fn present(&self, inport: &str) -> Option<Connection> {
        match self.inlet(inport, None).ok()? {
            Inlet::Remote(caller, remote) => caller.ties.remote(remote).map(Connection::Service),
            Inlet::Port(hosted, key) => hosted.ties.connection(&key).map(Connection::Port),
        }
    }

    /// Those of all components.
    #[must_use]
    pub fn all(&self) -> Vec<Connection> {
        self.components.all().iter().flat_map(|hosted| hosted.ties.connections()).collect()
    }

    /// Declares connections: each is made again when a side comes back, until somebody asks for
    /// another one there.
    pub fn declare(&self, entries: &[ConnectionEntry]) {
        self.declared.keep(entries);
    }

    /// Those that are declared.
    pub(crate) fn declared(&self) -> Vec<ConnectionEntry> {
        self.declared.all()
    }
}
