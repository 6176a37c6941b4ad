//! Locks that outlive a panic.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// A lock held.
pub(crate) type Guard<'a, T> = MutexGuard<'a, T>;

/// Locks, also after a thread panicked while it held the lock: what the locks of this crate guard
/// is consistent after every single change.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> Guard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
