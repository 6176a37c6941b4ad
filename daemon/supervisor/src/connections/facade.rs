//! Makes and removes connections by name, both of ports and of services.

use genom_configuration::ConnectionEntry;

use super::core::{Connections, Wanted};
use super::error::ConnectError;
use super::find::Inlet;
use crate::components::Hosted;
use crate::ties::Connection;
use genom_bus::Change;

impl Connections {
    /// Makes a connection on request, in place of an existing one. A deployment's declaration for
    /// this in port or remote is dropped. Blocks while codels are excluded.
    ///
    /// # Errors
    /// The connection could not be made. The previous one is kept.
    ///
    /// ```
    /// use genom_configuration::ConnectionEntry;
    /// use genom_supervisor::connections::Wanted;
    /// use genom_supervisor::{LoadRequest, Settings, Supervisor};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use genom_components::{Paths, Purpose, build};
    /// # let paths = Paths::of_workspace()?;
    /// let supervisor = Supervisor::new(Settings::default());
    /// for name in ["demo", "mission"] {
    ///     # let library = build(&paths, name, Purpose::Test)?.library;
    ///     supervisor.load(&LoadRequest { library, ..LoadRequest::default() })?;
    /// }
    /// let (inport, outport) = ("demo/parameter".into(), "mission/gain".into());
    /// let entry = ConnectionEntry { inport, outport, policy: None, over: None };
    /// supervisor.connections.connect(&Wanted::from(&entry))?;
    /// assert_eq!(supervisor.connections.all().len(), 1);
    /// assert!(supervisor.unload_all().is_empty());
    /// # Ok(())
    /// # }
    /// ```
    pub fn connect(&self, wanted: &Wanted) -> Result<Connection, ConnectError> {
        let made = self.make(wanted)?;
        self.declared.forget(&wanted.inport);
        Ok(made)
    }

    /// Makes a connection of a deployment, without dropping the declaration.
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

    /// Connects a remote of a component that is to take the place of another one.
    pub(crate) fn connect_heir(&self, heir: &Hosted, wanted: &Wanted) -> Result<(), ConnectError> {
        let name = wanted.inport.rsplit('/').next().unwrap_or_default();
        let remotes = &heir.model().remotes;
        let Some(remote) = remotes.find(|remote| remote.name == name) else { return Ok(()) };
        self.connect_service(heir, remote, wanted).map(drop)
    }

    /// Removes the connection of an in port or remote, and a deployment's declaration for it.
    /// Returns whether there was a connection. Blocks while codels are excluded.
    ///
    /// # Errors
    /// There is no such in port or remote, or a codel of its component does not return.
    pub fn disconnect(&self, inport: &str) -> Result<bool, ConnectError> {
        // First, because otherwise the connection could be made again in between.
        self.declared.forget(inport);
        self.take_away(inport)
    }

    /// Removes a connection, but keeps a declaration for it.
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

    /// The present connection of an in port or remote.
    #[must_use]
    pub fn present(&self, inport: &str) -> Option<Connection> {
        match self.inlet(inport, None).ok()? {
            Inlet::Remote(caller, remote) => caller.ties.remote(remote).map(Connection::Service),
            Inlet::Port(hosted, key) => hosted.ties.connection(&key).map(Connection::Port),
        }
    }

    /// The present connection of an in port or remote, or the one that is declared for it, as an
    /// entry of a deployment.
    #[must_use]
    pub fn entry(&self, inport: &str) -> Option<ConnectionEntry> {
        let declared = || self.declared.all().into_iter().find(|entry| entry.inport == inport);
        self.present(inport).map(|made| made.entry()).or_else(declared)
    }

    /// The connections of all components.
    #[must_use]
    pub fn all(&self) -> Vec<Connection> {
        self.components.all().iter().flat_map(|hosted| hosted.ties.connections()).collect()
    }

    /// Declares connections: each is made again whenever one side comes back, until somebody
    /// requests another one for the same in port or remote.
    pub fn declare(&self, entries: &[ConnectionEntry]) {
        self.declared.keep(entries);
    }

    /// The same; all other declarations are forgotten.
    pub(crate) fn declare_only(&self, entries: Vec<ConnectionEntry>) {
        self.declared.replace(entries);
    }

    /// The declared connections.
    pub(crate) fn declared(&self) -> Vec<ConnectionEntry> {
        self.declared.all()
    }
}
