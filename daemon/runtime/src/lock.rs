//! Locks that ignore poisoning.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A lock held.
pub(crate) type Guard<'a, T> = MutexGuard<'a, T>;

/// Locks the mutex, also after a thread panicked while holding it: data behind the locks of this
/// crate is consistent after every single change.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> Guard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A condition of what a mutex protects. To signal it takes a system call only while somebody waits.
#[derive(Debug, Default)]
pub(crate) struct Signal {
    condition: Condvar,
    /// Changed with the mutex locked, so that whoever has changed what it protects sees all who looked
    /// at it before.
    waiting: AtomicUsize,
}

impl Signal {
    /// Wakes all that wait. To be called after the change, for which the mutex was locked.
    pub(crate) fn notify_all(&self) {
        if self.waiting.load(Ordering::Relaxed) > 0 {
            self.condition.notify_all();
        }
    }

    /// Waits for the next signal.
    pub(crate) fn wait<'a, T>(&self, held: Guard<'a, T>) -> Guard<'a, T> {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        let held = self.condition.wait(held).unwrap_or_else(PoisonError::into_inner);
        self.waiting.fetch_sub(1, Ordering::Relaxed);
        held
    }

    /// The same, for a limited time.
    pub(crate) fn wait_timeout<'a, T>(&self, held: Guard<'a, T>, time: Duration) -> Guard<'a, T> {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        let waited = self.condition.wait_timeout(held, time);
        self.waiting.fetch_sub(1, Ordering::Relaxed);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;

    #[test]
    fn a_signal_wakes_all_that_wait_and_nobody_misses_a_change() {
        let shared = Arc::new((Mutex::new(0), Signal::default()));
        let waiters = [0; 4].map(|_| {
            let shared = Arc::clone(&shared);
            thread::spawn(move || {
                let (count, signal) = &*shared;
                for wanted in 1..=1000 {
                    let mut held = lock(count);
                    while *held < wanted {
                        held = signal.wait(held);
                    }
                }
            })
        });
        let (count, signal) = &*shared;
        for _ in 0..1000 {
            *lock(count) += 1;
            signal.notify_all();
        }
        waiters.into_iter().for_each(|waiter| waiter.join().unwrap());
        assert_eq!(signal.waiting.load(Ordering::Relaxed), 0);
        drop(signal.wait_timeout(lock(count), Duration::from_nanos(1)));
        assert_eq!(signal.waiting.load(Ordering::Relaxed), 0);
    }
}
