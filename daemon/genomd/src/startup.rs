//! How far the daemon is with what it was started with.

use std::sync::{Mutex, PoisonError};

use genom_supervisor::flag::Flag;

/// What is still to be loaded, and whether all is there.
pub(crate) struct Startup {
    /// Instance names, as far as they are known; the first is being loaded.
    to_load: Mutex<Vec<String>>,
    /// Every component is loaded.
    pub(crate) ready: Flag,
    /// Everything else of the deployment was done, too: connections, calls, activities.
    pub(crate) deployed: Flag,
}

impl Startup {
    pub(crate) fn new() -> Self {
        Self { to_load: Mutex::default(), ready: Flag::new(), deployed: Flag::new() }
    }

    /// These are to be loaded, in this order.
    pub(crate) fn begins(&self, names: Vec<String>) {
        *self.to_load.lock().unwrap_or_else(PoisonError::into_inner) = names;
    }

    /// The first of them is loaded.
    pub(crate) fn one_is_loaded(&self) {
        let mut names = self.to_load.lock().unwrap_or_else(PoisonError::into_inner);
        if !names.is_empty() {
            names.remove(0);
        }
    }

    /// Those that are still to be loaded, in order.
    pub(crate) fn to_load(&self) -> Vec<String> {
        self.to_load.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
