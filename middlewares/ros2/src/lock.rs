//! A lock that a thread which panicked has not spoiled for the others.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Has it to itself.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
