//! The event that wakes the worker threads of all daemons, including this one.

use std::sync::{Mutex, MutexGuard, PoisonError};

use iceoryx2::port::notifier::Notifier;

use crate::raw::Ipc;

/// Wakes all daemons.
pub(super) struct Bell(pub(super) Notifier<Ipc>);

impl Bell {
    pub(super) fn ring(&self) {
        // A daemon that could not be notified polls a little later anyway.
        let _ = self.0.notify();
    }
}

/// Locks a mutex, whether or not a thread panicked while holding it.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
