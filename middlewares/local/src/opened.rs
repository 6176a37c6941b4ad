//! The ports that have an open end.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_middleware::{Address, EndpointKind};

use crate::exchange::Exchange;

/// A port that has an open end.
pub(crate) struct Port {
    pub(crate) exchange: Arc<Exchange>,
    /// Number of open writing ends. The port is removed from the list when its last end closes.
    pub(crate) writers: usize,
    pub(crate) readers: usize,
}

/// Keeps a port in the list while one of its ends is open.
pub(crate) struct Opened {
    pub(crate) ports: Arc<Mutex<HashMap<Address, Port>>>,
    pub(crate) at: Address,
    pub(crate) kind: EndpointKind,
}

pub(crate) fn lock(
    ports: &Mutex<HashMap<Address, Port>>,
) -> MutexGuard<'_, HashMap<Address, Port>> {
    ports.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Opened {
    fn drop(&mut self) {
        let mut ports = lock(&self.ports);
        let Entry::Occupied(mut port) = ports.entry(self.at.clone()) else { return };
        match self.kind {
            EndpointKind::Publisher => port.get_mut().writers -= 1,
            _ => port.get_mut().readers -= 1,
        }
        if port.get().writers + port.get().readers == 0 {
            port.remove();
        }
    }
}
