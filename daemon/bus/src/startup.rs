//! Progress of loading what the daemon was started with.

use std::sync::{Mutex, PoisonError};

use crate::flag::Flag;

/// What is still to be loaded.
#[derive(Debug, Default)]
pub struct Startup {
    /// Instance names, as far as known; the first is being loaded.
    to_load: Mutex<Vec<String>>,
    /// Raised when every component is loaded.
    pub ready: Flag,
    /// Raised when the rest of the deployment is applied, too: connections, calls, activities.
    pub deployed: Flag,
}

impl Startup {
    /// Sets the components to be loaded, in order.
    pub fn begins(&self, names: Vec<String>) {
        *self.to_load.lock().unwrap_or_else(PoisonError::into_inner) = names;
    }

    /// The first of them is loaded.
    pub fn one_is_loaded(&self) {
        let mut names = self.to_load.lock().unwrap_or_else(PoisonError::into_inner);
        if !names.is_empty() {
            names.remove(0);
        }
    }

    /// The components still to be loaded, in order.
    pub fn to_load(&self) -> Vec<String> {
        self.to_load.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
