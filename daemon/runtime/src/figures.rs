//! What is counted of each codel and task while it runs.

use crate::cycles::Cycles;
use crate::histogram::{Counter, Histogram};
use crate::task::pace::Pace;

/// Figures on one codel.
#[derive(Debug, Default)]
pub(crate) struct CodelFigures {
    pub(crate) durations: Histogram,
    /// Calls longer than the codel's stated `wcet`.
    pub(crate) above_wcet: Counter,
}

/// Figures on one task.
#[derive(Debug, Default)]
pub(crate) struct TaskFigures {
    /// From a tick, or from waking up, until there is nothing left to do.
    pub(crate) cycles: Cycles,
    /// From the date of a tick to the task's start.
    pub(crate) lateness: Histogram,
    /// Ticks that came while the task was still at work, or slept beyond the one before.
    pub(crate) overruns: Pace,
}
