//! Components in other processes of the same daemon: both sides meet on shared memory, whatever
//! middleware the daemon has by default.

use std::sync::{Arc, OnceLock};

use genom_configuration::BackendNames;

/// The middleware between processes of one daemon.
pub(super) const SHARED: &str = "shm";

/// The middleware that reaches no other process.
const WITHIN: &str = "local";

/// What these are in a process that components of others are to reach: shared memory in place of
/// what stays within a process.
#[must_use]
pub fn between_processes(names: &BackendNames) -> BackendNames {
    let all = names.names().iter().map(|name| if name == WITHIN { SHARED } else { name });
    BackendNames::from(all.collect::<Vec<_>>().join("+").as_str())
}

/// Says whether another process of this daemon holds a component.
pub(super) type Holds = Box<dyn Fn(&str) -> bool + Send + Sync>;

/// Who knows of other processes, once somebody does.
#[derive(Clone, Default)]
pub(super) struct Elsewhere(Arc<OnceLock<Holds>>);

impl Elsewhere {
    /// Whoever says it first is the one program that has the processes.
    pub(super) fn ask(&self, holds: Holds) {
        let _ = self.0.set(holds);
    }

    pub(super) fn holds(&self, component: &str) -> bool {
        self.0.get().is_some_and(|holds| holds(component))
    }
}
