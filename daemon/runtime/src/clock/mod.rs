//! Time: the machine's monotonic clock, or one that a supervisor steps.

mod virtual_clock;

use std::sync::Arc;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

pub(crate) use virtual_clock::Driven;
pub use virtual_clock::VirtualClock;

/// The clock of an instance. Dates are nanoseconds.
#[derive(Clone, Debug, Default)]
pub enum Clock {
    /// `CLOCK_MONOTONIC`; each task has a thread of its own.
    #[default]
    Monotonic,
    /// A clock that advances when it is told; tasks run in the thread that steps it, so the same
    /// inputs give the same sequence of codel calls.
    Virtual(Arc<VirtualClock>),
}

impl Clock {
    /// The date now.
    #[must_use]
    #[inline]
    pub fn now(&self) -> u64 {
        match self {
            Clock::Monotonic => monotonic(),
            Clock::Virtual(clock) => clock.now(),
        }
    }
}

#[inline]
fn monotonic() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
}

/// Sleeps until a date of the monotonic clock, whatever signals come.
pub(crate) fn sleep_until(date: u64) {
    let request = Timespec {
        tv_sec: i64::try_from(date / 1_000_000_000).unwrap_or(i64::MAX),
        tv_nsec: i64::try_from(date % 1_000_000_000).unwrap_or(0),
    };
    while clock_nanosleep_absolute(ClockId::Monotonic, &request) == Err(rustix::io::Errno::INTR) {}
}
