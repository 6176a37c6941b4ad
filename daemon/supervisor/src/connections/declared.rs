//! The connections that deployments declared. They are made again by `keep`.

use std::sync::{Mutex, PoisonError};

use genom_configuration::ConnectionEntry;

/// The connections that deployments declared, at most one for each in port or remote.
#[derive(Debug, Default)]
pub(super) struct Declared {
    entries: Mutex<Vec<ConnectionEntry>>,
}

impl Declared {
    /// Adds declarations; each replaces an earlier one for the same in port or remote.
    pub(super) fn keep(&self, new: &[ConnectionEntry]) {
        self.with(|entries| {
            entries.retain(|old| !new.iter().any(|entry| entry.inport == old.inport));
            entries.extend_from_slice(new);
        });
    }

    /// Replaces all declarations.
    pub(super) fn replace(&self, new: Vec<ConnectionEntry>) {
        self.with(|entries| *entries = new);
    }

    /// Removes a declaration, because somebody disconnected this in port or remote or connected it
    /// otherwise.
    pub(super) fn forget(&self, inport: &str) {
        self.with(|entries| entries.retain(|entry| entry.inport != inport));
    }

    /// All declarations.
    pub(super) fn all(&self) -> Vec<ConnectionEntry> {
        self.with(|entries| entries.clone())
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<ConnectionEntry>) -> T) -> T {
        work(&mut self.entries.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
