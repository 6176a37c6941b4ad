//! A clock that a supervisor steps, and that drives the tasks of all its instances.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError, Weak};
use std::time::Duration;

use super::nanos::nanos;

/// What a virtual clock drives: an instance.
pub(crate) trait Driven: Send + Sync {
    /// Date after now at which it has something to do, if nothing happens before.
    fn next_date(&self) -> Option<u64>;
    /// Runs all that is to be done at this date; `false` when nothing was.
    fn run(&self, now: u64) -> bool;
    /// Waits until activities that were accepted are where a tick finds them. Who asked is told
    /// before that, and may step at once from another thread.
    fn take_in_accepted(&self);
}

/// Time that advances when it is told.
///
/// One thread does everything, so a codel that waits for another component's activity waits for
/// ever; attributes and functions of others are served where they are asked for.
#[derive(Default)]
pub struct VirtualClock {
    now: AtomicU64,
    /// Instances in order of start, which is the order they run in.
    driven: Mutex<Vec<Weak<dyn Driven>>>,
    /// One step at a time.
    stepping: Mutex<()>,
}

impl fmt::Debug for VirtualClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VirtualClock({} ns)", self.now())
    }
}

/// Rounds of work at one date before time goes on: an activity that never pauses would
/// otherwise stop it for ever.
const MOST_ROUNDS: usize = 1000;

impl VirtualClock {
    /// A clock at zero.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The date in nanoseconds.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.now.load(Ordering::Acquire)
    }

    /// Advances by `duration`, running every tick on the way at its date, and what follows from
    /// it. Stepping by zero runs what is pending now.
    ///
    /// Must not be called by a codel, nor by the reply to a request.
    pub fn step(&self, duration: Duration) {
        let _one = self.stepping.lock().unwrap_or_else(PoisonError::into_inner);
        let span = nanos(duration);
        let target = self.now().saturating_add(span);
        for driven in self.driven() {
            driven.take_in_accepted();
        }
        self.settle();
        loop {
            let next = self.driven().iter().filter_map(|driven| driven.next_date()).min();
            match next.filter(|date| *date <= target) {
                Some(date) => {
                    self.now.store(date.max(self.now()), Ordering::Release);
                    self.settle();
                }
                None => break,
            }
        }
        self.now.store(target, Ordering::Release);
    }

    pub(crate) fn drive(&self, driven: Weak<dyn Driven>) {
        self.driven.lock().unwrap_or_else(PoisonError::into_inner).push(driven);
    }

    fn driven(&self) -> Vec<std::sync::Arc<dyn Driven>> {
        let mut driven = self.driven.lock().unwrap_or_else(PoisonError::into_inner);
        driven.retain(|driven| driven.strong_count() > 0);
        driven.iter().filter_map(Weak::upgrade).collect()
    }

    fn settle(&self) {
        let driven = self.driven();
        let now = self.now();
        for _ in 0..MOST_ROUNDS {
            // Everybody has a turn in each round.
            if driven.iter().filter(|driven| driven.run(now)).count() == 0 {
                break;
            }
        }
    }
}
