//! What wakes the threads of all daemons, ours among them.

use std::sync::{Mutex, MutexGuard, PoisonError};

use iceoryx2::port::notifier::Notifier;

use crate::raw::Ipc;

/// Wakes all daemons.
pub(super) struct Bell(pub(super) Notifier<Ipc>);

impl Bell {
    pub(super) fn ring(&self) {
        // Whoever could not be woken looks by itself a little later.
        let _ = self.0.notify();
    }
}

/// Whoever held it before.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
