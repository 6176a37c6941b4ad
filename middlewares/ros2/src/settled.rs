//! Waits for what is not known yet, since discovery takes time.

use std::sync::{Condvar, MutexGuard, PoisonError};
use std::time::Instant;

/// Looks at a state each time it has changed, until what is found is the last word, or until `end`.
pub(crate) fn settled<'a, S, F>(
    changed: &Condvar,
    mut state: MutexGuard<'a, S>,
    end: Instant,
    look: impl Fn(&S) -> F,
    is_last: impl Fn(&F) -> bool,
) -> (MutexGuard<'a, S>, F) {
    loop {
        let found = look(&state);
        let left = end.saturating_duration_since(Instant::now());
        if is_last(&found) || left.is_zero() {
            return (state, found);
        }
        state = changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
    }
}
