//! Figures that are recorded for each codel and task while it runs.

use crate::cycles::Cycles;
use crate::histogram::{Counter, Histogram};
use crate::task::pace::Pace;

/// Figures of one codel.
#[derive(Debug, Default)]
pub(crate) struct CodelFigures {
    pub(crate) durations: Histogram,
    /// Calls that took longer than the codel's declared `wcet`.
    pub(crate) above_wcet: Counter,
}

/// Figures of one task.
#[derive(Debug, Default)]
pub(crate) struct TaskFigures {
    /// Durations from a tick, or a wake-up, until there is nothing left to do.
    pub(crate) cycles: Cycles,
    /// Durations from the date of a tick to the start of work.
    pub(crate) lateness: Histogram,
    /// Ticks missed because the task was still at work, or slept beyond the next one.
    pub(crate) overruns: Pace,
}
