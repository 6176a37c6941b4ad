//! Locks that ignore poisoning.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// A lock held.
pub(crate) type Guard<'a, T> = MutexGuard<'a, T>;

/// Locks the mutex, also after a thread panicked while holding it: data behind the locks of this
/// crate is consistent after every single change.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> Guard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
