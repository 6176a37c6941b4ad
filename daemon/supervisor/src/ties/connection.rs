//! What is behind an in port or a remote.

use genom_configuration::place::Place;
use genom_configuration::{ConnectionEntry, terms};
use genom_middleware::{Address, Policy};

/// A connection that is there.
#[derive(Clone, Debug)]
pub enum Connection {
    /// An in port reads an out port.
    Port(PortConnection),
    /// A remote calls a service.
    Service(ServiceConnection),
}

/// What feeds an in port.
#[derive(Clone, Debug)]
pub struct PortConnection {
    /// The in port.
    pub inport: Address,
    /// The out port that feeds it.
    pub outport: Address,
    /// The middleware between them.
    pub backend: String,
    /// What the reader gets of the samples it has not read.
    pub policy: Policy,
    /// Whether the middleware was asked for by name: then the connection stays on it.
    pub fixed: bool,
}

/// The service behind a remote.
#[derive(Clone, Debug)]
pub struct ServiceConnection {
    /// The remote.
    pub remote: Address,
    /// The service that it calls.
    pub service: Address,
    /// The middleware it is called through; none within the daemon.
    pub backend: Option<String>,
    /// Whether the middleware was asked for by name: then calls stay on it.
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

    /// The middleware between them; none of a call within the daemon.
    #[must_use]
    pub fn backend(&self) -> Option<&str> {
        match self {
            Connection::Port(made) => Some(&made.backend),
            Connection::Service(made) => made.backend.as_deref(),
        }
    }

    /// What the reader gets of the samples it has not read; a remote has none.
    #[must_use]
    pub fn policy(&self) -> Option<Policy> {
        match self {
            Connection::Port(made) => Some(made.policy),
            Connection::Service(_) => None,
        }
    }

    fn fixed(&self) -> bool {
        match self {
            Connection::Port(made) => made.fixed,
            Connection::Service(made) => made.fixed,
        }
    }

    /// As an entry of a file, which gives the same connection when it is applied.
    #[must_use]
    pub fn entry(&self) -> ConnectionEntry {
        let to = self.outport();
        let backend = self.backend().filter(|_| self.fixed()).map(str::to_owned);
        // `/scan`, a name of somebody else's, is one on its middleware only.
        let (outport, backend) = match backend {
            Some(on) if to.instance.is_empty() => (format!("{on}:{to}"), None),
            backend => (to.to_string(), backend),
        };
        let policy = self.policy().map(|policy| terms::told_policy(policy).to_string());
        ConnectionEntry { inport: self.inport().to_string(), outport, policy, backend }
    }

    /// Whether it is what an entry asks for.
    #[must_use]
    pub fn is(&self, wanted: &ConnectionEntry) -> bool {
        let Ok(place) = Place::parse(&wanted.outport) else { return false };
        let backend = wanted.backend.as_deref().or(place.backend.as_deref());
        let policy = match self.policy() {
            Some(policy) => policy == terms::policy(wanted.policy()),
            None => wanted.policy.is_none(),
        };
        *self.outport() == place.address
            && policy
            && backend.is_none_or(|backend| self.backend() == Some(backend))
    }
}
