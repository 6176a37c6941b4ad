//! What it takes to make connections, and what is asked of one.

use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_configuration::{ConnectionEntry, Offers, terms};
use genom_middleware::{Middleware, Policy};
use genom_registry::Backends;

use super::declared::Declared;
use super::error::Kind;
use super::opening::Opening;
use crate::bus::Bus;
use crate::components::Components;

/// On a network others become visible a while after they, or we, came up.
pub(super) const NETWORK: Duration = Duration::from_secs(2);
/// Between two looks at a network.
pub(super) const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// The connections of a supervisor's components, and all it takes to make them.
#[derive(Clone)]
pub struct Connections {
    pub(super) backends: Arc<Backends>,
    pub(super) components: Arc<Components>,
    pub(super) bus: Arc<Bus>,
    pub(super) opening: Opening,
    pub(super) offers: Arc<Offers>,
    pub(super) declared: Arc<Declared>,
}

/// A connection to make.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The in port, `component/port` or `component/port/element`, or the remote,
    /// `component/remote`; of this daemon.
    pub inport: String,
    /// Which of the two it must be, when only one is meant.
    pub kind: Option<Kind>,
    /// The out port or the service, of any daemon; a middleware may stand before it.
    pub outport: String,
    /// What the reader gets of the samples it has not read: the last one, unless this says more. A
    /// remote takes none.
    pub policy: Option<Policy>,
    /// The middleware. By default the out port's, when it is in this daemon, else that of the in
    /// port; within the daemon services are called without one.
    pub backend: Option<String>,
    /// Connect also when the other side is not there yet.
    pub wait: bool,
    /// How long to look for it on a network.
    pub patience: Patience,
}

impl From<&ConnectionEntry> for Wanted {
    /// What an entry of a file asks for: who applies it looks again if the other side is not there.
    fn from(entry: &ConnectionEntry) -> Self {
        Self {
            inport: entry.inport.clone(),
            kind: None,
            outport: entry.outport.clone(),
            policy: entry.policy.is_some().then(|| terms::policy(entry.policy())),
            backend: entry.backend.clone(),
            wait: false,
            patience: Patience::None,
        }
    }
}

/// How long to look on a network for what does not show there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// Not at all: somebody asks again.
    None,
    /// Until this daemon has been there for long enough to see all that is there. What comes up at
    /// this very moment is not waited for: a component asks, whose other requests wait meanwhile.
    Newcomer,
    /// As long as what comes up now may take to become visible: a person asks.
    Full,
}

impl Patience {
    /// Until when to look on this middleware.
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
        }
    }

    /// What it takes to open ends of ports.
    pub(crate) fn opening(&self) -> &Opening {
        &self.opening
    }
}
