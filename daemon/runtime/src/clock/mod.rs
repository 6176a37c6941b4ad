//! Clocks: the monotonic clock of the machine, or one that a supervisor steps.

mod nanos;
mod stage;
mod virtual_clock;

use std::sync::Arc;

use rustix::time::{ClockId, clock_gettime};

pub use nanos::nanos;
pub use stage::{OnStage, Stage, Turn};
pub(crate) use virtual_clock::Driven;
pub use virtual_clock::VirtualClock;

/// The clock of an instance. Dates are in nanoseconds.
#[derive(Clone, Debug, Default)]
pub enum Clock {
    /// `CLOCK_MONOTONIC`; threads run the tasks, as [`Execution`](crate::Execution) says.
    #[default]
    Monotonic,
    /// A clock that is stepped; tasks run in the thread that steps it, so equal inputs give equal
    /// sequences of codel calls.
    Virtual(Arc<VirtualClock>),
    /// A clock on which codels may take time; threads run the tasks, and wait for their turns.
    Staged(Arc<dyn Stage>),
}

impl Clock {
    /// The current date.
    #[must_use]
    #[inline]
    pub fn now(&self) -> u64 {
        match self {
            Clock::Monotonic => monotonic(),
            Clock::Virtual(clock) => clock.now(),
            Clock::Staged(stage) => stage.now(),
        }
    }

    /// The monotonic date of the machine when this clock shows `date`, which [`now`](Self::now) has
    /// just returned. Durations of codels are in real time, whatever the component's clock.
    #[inline]
    pub(crate) fn real(&self, date: u64) -> u64 {
        match self {
            Clock::Monotonic => date,
            Clock::Virtual(_) | Clock::Staged(_) => monotonic(),
        }
    }
}

/// The monotonic date of the machine.
#[inline]
pub(crate) fn monotonic() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
}
