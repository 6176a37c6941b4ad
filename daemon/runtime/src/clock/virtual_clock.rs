//! A clock that a supervisor steps, and that runs the tasks of all its instances.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError, Weak};
use std::time::Duration;

use super::nanos::nanos;

/// An instance, as the virtual clock drives it.
pub(crate) trait Driven: Send + Sync {
    /// The next date at which it has something to do, if nothing else happens before.
    fn next_date(&self) -> Option<u64>;
    /// Runs everything that is due at this date; `false` when nothing was.
    fn run(&self, now: u64) -> bool;
    /// Waits until accepted activities have reached their tasks' queues. The client is informed
    /// before that, and may step the clock at once from another thread.
    fn take_in_accepted(&self);
}

/// A clock that advances only when it is stepped.
///
/// One thread runs everything, so a codel that waits for an activity of another component waits for
/// ever; attributes and functions of other components are served on the calling thread.
#[derive(Default)]
pub struct VirtualClock {
    now: AtomicU64,
    /// Instances in order of start, in which they also run.
    driven: Mutex<Vec<Weak<dyn Driven>>>,
    /// Serialises steps.
    stepping: Mutex<()>,
}

impl fmt::Debug for VirtualClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VirtualClock({} ns)", self.now())
    }
}

/// Rounds of work at one date before time advances: an activity that never pauses would otherwise
/// prevent that for ever.
const MOST_ROUNDS: usize = 1000;

impl VirtualClock {
    /// A clock at zero.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The current date in nanoseconds.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.now.load(Ordering::Acquire)
    }

    /// Advances by `duration`; every tick on the way runs at its date, with all that follows from
    /// it. A step of zero runs what is pending now.
    ///
    /// Codels and replies to requests must not call this.
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
            // Each instance runs once in each round.
            if driven.iter().filter(|driven| driven.run(now)).count() == 0 {
                break;
            }
        }
    }
}
