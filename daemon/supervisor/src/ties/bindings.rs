//! Which middlewares a component's ports and services are on, and in what quality.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use genom_middleware::Quality;

use genom_configuration::{BackendNames, QosEntry, terms};

/// The middlewares of one component: its own, and those of ports that have others.
#[derive(Debug)]
pub struct Bindings {
    state: Mutex<State>,
    qos: QosEntry,
    /// Held while the component moves: one move at a time.
    turn: Mutex<()>,
}

#[derive(Clone, Debug)]
struct State {
    component: BackendNames,
    ports: BTreeMap<String, BackendNames>,
}

impl Bindings {
    /// A component on these, and its ports that are elsewhere.
    pub fn new(
        component: BackendNames,
        ports: BTreeMap<String, BackendNames>,
        qos: QosEntry,
    ) -> Self {
        Self { state: Mutex::new(State { component, ports }), qos, turn: Mutex::default() }
    }

    /// What is asked of a port, wherever it is.
    pub fn quality(&self, port: &str) -> Quality {
        terms::quality(&self.qos.of(port))
    }

    /// Those of services, and of ports that have no others.
    pub fn component(&self) -> BackendNames {
        self.with(|state| state.component.clone())
    }

    /// Those of a port.
    pub fn port(&self, name: &str) -> BackendNames {
        self.with(|state| state.ports.get(name).unwrap_or(&state.component).clone())
    }

    /// Ports that have others than their component.
    pub fn ports(&self) -> BTreeMap<String, BackendNames> {
        self.with(|state| state.ports.clone())
    }

    /// Waits for the move under way, if there is one.
    pub fn turn(&self) -> MutexGuard<'_, ()> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The component moved, and with it all its ports.
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
