//! The middlewares of a component's ports and services, and their quality of service.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use genom_middleware::Quality;

use genom_configuration::{BackendNames, QosEntry, terms};

/// The middlewares of one component, and of its ports that use others.
#[derive(Debug)]
pub struct Bindings {
    state: Mutex<State>,
    qos: QosEntry,
    /// Locked while the component moves, so that only one move is made at a time.
    turn: Mutex<()>,
}

#[derive(Clone, Debug)]
struct State {
    component: BackendNames,
    ports: BTreeMap<String, BackendNames>,
}

impl Bindings {
    /// A component on the middlewares `own`, with exceptions for some ports.
    pub fn new(
        component: BackendNames,
        ports: BTreeMap<String, BackendNames>,
        qos: QosEntry,
    ) -> Self {
        Self { state: Mutex::new(State { component, ports }), qos, turn: Mutex::default() }
    }

    /// The quality of service requested for a port, on any middleware.
    pub fn quality(&self, port: &str) -> Quality {
        terms::quality(&self.qos.of(port))
    }

    /// Middlewares of its services, and of ports that have no others.
    pub fn component(&self) -> BackendNames {
        self.with(|state| state.component.clone())
    }

    /// Middlewares of a port.
    pub fn port(&self, name: &str) -> BackendNames {
        self.with(|state| state.ports.get(name).unwrap_or(&state.component).clone())
    }

    /// Ports whose middlewares differ from the component's.
    pub fn ports(&self) -> BTreeMap<String, BackendNames> {
        self.with(|state| state.ports.clone())
    }

    /// Waits for the present move, if any, and locks out others.
    pub fn turn(&self) -> MutexGuard<'_, ()> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The component moved with all its ports.
    pub fn move_component(&self, to: &BackendNames) {
        self.with(|state| *state = State { component: to.clone(), ports: BTreeMap::new() });
    }

    /// A port moved.
    pub fn move_port(&self, name: &str, to: &BackendNames) {
        self.with(|state| {
            if state.component == *to {
                state.ports.remove(name);
            } else {
                state.ports.insert(name.to_owned(), to.clone());
            }
        });
    }

    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
