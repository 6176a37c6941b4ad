//! What codels write to or read from, until it is taken from them: their component did not stop in
//! time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

/// How long a thread of the component may take to come out of a write or a read that has just begun.
const PATIENCE: Duration = Duration::from_millis(200);

/// Interval between attempts.
const TICK: Duration = Duration::from_millis(1);

/// An end of a connection. Locked by codels at each write or read, and by the supervisor only while
/// all codels are excluded, or for the moment that it takes it away: a codel never waits for it.
#[derive(Debug)]
pub(crate) struct Held<T> {
    end: Mutex<T>,
    cut: AtomicBool,
    /// What is there once it was taken away.
    nothing: fn() -> T,
}

impl<T> Held<T> {
    pub(crate) fn new(end: T, nothing: fn() -> T) -> Self {
        Self { end: Mutex::new(end), cut: AtomicBool::new(false), nothing }
    }

    /// What a codel does with it.
    pub(crate) fn used<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let done = work(&mut end);
        if self.cut.load(Ordering::Acquire) {
            let old = std::mem::replace(&mut *end, (self.nothing)());
            drop(end);
            drop(old);
        }
        done
    }

    /// Looks at it; or changes it, while all codels are excluded.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        work(&mut self.end.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Takes it away, and drops it. Returns `false` if some codel does not come out of its write or
    /// read: it is dropped when that one does.
    pub(crate) fn cut(&self) -> bool {
        self.cut_within(PATIENCE)
    }

    fn cut_within(&self, patience: Duration) -> bool {
        self.cut.store(true, Ordering::Release);
        let end = Instant::now() + patience;
        loop {
            let mut taken = match self.end.try_lock() {
                Ok(taken) => taken,
                Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
                Err(TryLockError::WouldBlock) if Instant::now() < end => {
                    thread::park_timeout(TICK);
                    continue;
                }
                Err(TryLockError::WouldBlock) => return false,
            };
            let old = std::mem::replace(&mut *taken, (self.nothing)());
            // Dropped after the lock is released, so that a codel that comes now does not wait.
            drop(taken);
            drop(old);
            return true;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::mpsc::channel;

    use super::*;

    /// An end of which it is known whether it is still open.
    fn end() -> (Held<Option<Arc<()>>>, impl Fn() -> bool) {
        let open = Arc::new(());
        let is_open = Arc::downgrade(&open);
        (Held::new(Some(open), || None), move || is_open.upgrade().is_some())
    }

    #[test]
    fn an_end_that_nobody_uses_is_dropped_at_once() {
        let (held, is_open) = end();
        assert!(is_open() && held.cut() && !is_open());
        assert!(held.used(|end| end.is_none()));
    }

    #[test]
    fn an_end_in_use_is_dropped_when_that_use_is_over() {
        let (held, is_open) = end();
        let ((tell, told), (go_on, may_go_on)) = (channel(), channel());
        let held = &held;
        thread::scope(|scope| {
            let user = scope.spawn(move || {
                held.used(|_| {
                    tell.send(()).unwrap();
                    may_go_on.recv().unwrap();
                });
            });
            told.recv().unwrap();
            assert!(!held.cut_within(TICK) && is_open());
            go_on.send(()).unwrap();
            user.join().unwrap();
            assert!(!is_open());
        });
    }

    #[test]
    fn a_use_that_ends_soon_is_waited_for() {
        let (held, is_open) = end();
        let (tell, told) = channel();
        thread::scope(|scope| {
            scope.spawn(|| {
                held.used(|_| {
                    tell.send(()).unwrap();
                    thread::park_timeout(TICK);
                });
            });
            told.recv().unwrap();
            assert!(held.cut_within(Duration::from_secs(60)) && !is_open());
        });
    }
}
