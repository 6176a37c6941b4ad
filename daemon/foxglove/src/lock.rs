//! Locks that stay usable.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks it, also after a panic of whoever held it.
pub(crate) fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
