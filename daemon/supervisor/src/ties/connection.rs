//! The connections of in ports and remotes.

use genom_configuration::place::Place;
use genom_configuration::{ConnectionEntry, terms};
use genom_middleware::{Address, Policy};

/// An existing connection.
#[derive(Clone, Debug)]
pub enum Connection {
    /// An in port reads an out port.
    Port(PortConnection),
    /// A remote calls a service.
    Service(ServiceConnection),
}

/// The connection of an in port.
#[derive(Clone, Debug)]
pub struct PortConnection {
    /// The in port.
    pub inport: Address,
    /// The out port that it reads.
    pub outport: Address,
    /// Name of the middleware.
    pub backend: String,
    /// Which unread samples are kept for the reader.
    pub policy: Policy,
    /// Whether the middleware was requested explicitly: the connection then stays on it.
    pub fixed: bool,
}

/// The connection of a remote.
#[derive(Clone, Debug)]
pub struct ServiceConnection {
    /// The remote.
    pub remote: Address,
    /// The service that it calls.
    pub service: Address,
    /// Name of the middleware; `None` if the service is in this daemon.
    pub backend: Option<String>,
    /// Whether the middleware was requested explicitly: the connection then stays on it.
    pub fixed: bool,
}

impl Connection {
    /// The in port, or the remote.
    #[must_use]
    pub fn inport(&self) -> &Address {
        match self {
            Connection::Port(made) => &made.inport,
            Connection::Service(made) => &made.remote,
        }
    }

    /// The out port, or the service.
    #[must_use]
    pub fn outport(&self) -> &Address {
        match self {
            Connection::Port(made) => &made.outport,
            Connection::Service(made) => &made.service,
        }
    }

    /// Name of the middleware; `None` for a service in this daemon.
    #[must_use]
    pub fn backend(&self) -> Option<&str> {
        match self {
            Connection::Port(made) => Some(&made.backend),
            Connection::Service(made) => made.backend.as_deref(),
        }
    }

    /// Which unread samples are kept for the reader; `None` for a remote.
    #[must_use]
    pub fn policy(&self) -> Option<Policy> {
        match self {
            Connection::Port(made) => Some(made.policy),
            Connection::Service(_) => None,
        }
    }

    /// Whether the middleware was requested explicitly.
    #[must_use]
    pub fn fixed(&self) -> bool {
        match self {
            Connection::Port(made) => made.fixed,
            Connection::Service(made) => made.fixed,
        }
    }

    /// The connection as an entry of a deployment; applying the entry makes the same connection.
    #[must_use]
    pub fn entry(&self) -> ConnectionEntry {
        let to = self.outport();
        let over = self.backend().filter(|_| self.fixed()).map(str::to_owned);
        // An absolute foreign name such as `/scan` exists on its middleware only.
        let (outport, over) = match over {
            Some(on) if to.instance.is_empty() => (format!("{on}:{to}"), None),
            over => (to.to_string(), over),
        };
        let policy = self.policy().map(|policy| terms::told_policy(policy).to_string());
        ConnectionEntry { inport: self.inport().to_string(), outport, policy, over }
    }

    /// Whether it is the connection that an entry asks for.
    #[must_use]
    pub fn is(&self, wanted: &ConnectionEntry) -> bool {
        let Ok(place) = Place::parse(&wanted.outport) else { return false };
        let over = wanted.over.as_deref().or(place.backend.as_deref());
        let policy = match self.policy() {
            Some(policy) => policy == terms::policy(wanted.policy()),
            None => wanted.policy.is_none(),
        };
        *self.outport() == place.address
            && policy
            && over == self.backend().filter(|_| self.fixed())
    }
}
