//! The state needed to make connections, and the parameters of one.

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_configuration::{ConnectionEntry, Offers, terms};
use genom_middleware::{Middleware, Policy};
use genom_registry::Backends;

use super::declared::Declared;
use super::elsewhere::Elsewhere;
use super::error::Kind;
use super::opening::Opening;
use crate::components::Components;
use genom_bus::Bus;

/// How long it may take until endpoints on a network become visible after they, or this daemon,
/// started.
pub(super) const NETWORK: Duration = Duration::from_secs(2);
/// Interval between two checks for endpoints on a network.
pub(super) const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// Makes, moves and removes the connections of a supervisor's components.
#[derive(Clone)]
pub struct Connections {
    pub(super) backends: Arc<Backends>,
    pub(super) components: Arc<Components>,
    pub(super) bus: Arc<Bus>,
    pub(super) opening: Opening,
    pub(super) offers: Arc<Offers>,
    pub(super) declared: Arc<Declared>,
    pub(super) elsewhere: Elsewhere,
}

/// A connection to make.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The in port, `component/port` or `component/port/element`, or the remote,
    /// `component/remote`, of this daemon.
    pub inport: String,
    /// Set if only a port, or only a remote, is meant.
    pub kind: Option<Kind>,
    /// The out port or the service, of any daemon; optionally with its middleware.
    pub outport: String,
    /// Which unread samples are kept for the reader; by default only the last one. Not for a
    /// remote.
    pub policy: Option<Policy>,
    /// The middleware, on which the out port is opened if it is in this process and not there yet.
    /// By default that of the out port if it is in this daemon, else that of the in port; services
    /// within the daemon are called without a middleware.
    pub over: Option<String>,
    /// Connect even if the other side does not exist yet.
    pub wait: bool,
    /// How long to wait for it to become visible on a network.
    pub patience: Patience,
}

impl From<&ConnectionEntry> for Wanted {
    /// The connection of a deployment's entry. The caller tries again if the other side does not
    /// exist yet.
    fn from(entry: &ConnectionEntry) -> Self {
        Self {
            inport: entry.inport.clone(),
            kind: None,
            outport: entry.outport.clone(),
            policy: entry.policy.is_some().then(|| terms::policy(entry.policy())),
            over: entry.over.clone(),
            wait: false,
            patience: Patience::None,
        }
    }
}

/// How long to wait for an endpoint that is not visible on a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// Not at all: the caller tries again.
    None,
    /// Until this daemon has run for long enough to see all existing endpoints. Endpoints created
    /// right now are not waited for: for requests of codels, which would delay other requests of
    /// their component.
    Newcomer,
    /// Long enough to see endpoints that are created right now: for requests of users.
    Full,
}

impl Patience {
    /// Until when to wait on this middleware.
    pub(super) fn end(self, backends: &Backends, middleware: &dyn Middleware) -> Instant {
        let now = Instant::now();
        let network = middleware.capabilities().cross_host;
        match self {
            Patience::Newcomer if network => {
                backends.open_since(middleware.name()).unwrap_or(now) + NETWORK
            }
            Patience::Full if network => now + NETWORK,
            _ => now,
        }
    }
}

impl Connections {
    pub(crate) fn new(
        components: &Arc<Components>,
        bus: &Arc<Bus>,
        opening: Opening,
        offers: Offers,
    ) -> Self {
        Self {
            backends: Arc::clone(&opening.backends),
            components: Arc::clone(components),
            bus: Arc::clone(bus),
            opening,
            offers: Arc::new(offers),
            declared: Arc::default(),
            elsewhere: Elsewhere::default(),
        }
    }

    /// What is needed to open publishers of ports.
    pub(crate) fn opening(&self) -> &Opening {
        &self.opening
    }
}
