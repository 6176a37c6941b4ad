//! The connections that deployments declared; `keep` makes them again.

use std::sync::{Mutex, PoisonError};

use genom_configuration::ConnectionEntry;

/// The connections that deployments declared, one an in port or remote.
#[derive(Debug, Default)]
pub(super) struct Declared {
    entries: Mutex<Vec<ConnectionEntry>>,
}

impl Declared {
    /// These are to be kept from now on, in place of others of the same in ports.
    pub(super) fn keep(&self, new: &[ConnectionEntry]) {
        self.with(|entries| {
            entries.retain(|old| !new.iter().any(|entry| entry.inport == old.inport));
            entries.extend_from_slice(new);
        });
    }

    /// Somebody disconnected or connected this in port or remote otherwise: that holds.
    pub(super) fn forget(&self, inport: &str) {
        self.with(|entries| entries.retain(|entry| entry.inport != inport));
    }

    /// All of them.
    pub(super) fn all(&self) -> Vec<ConnectionEntry> {
        self.with(|entries| entries.clone())
    }

    fn with<T>(&self, work: impl FnOnce(&mut Vec<ConnectionEntry>) -> T) -> T {
        work(&mut self.entries.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
