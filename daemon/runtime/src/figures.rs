//! Figures that are recorded for each codel and task while it runs.

use crate::body::Returned;
use crate::cycles::Cycles;
use crate::histogram::{Counter, Histogram};
use crate::plan::Yields;
use crate::task::pace::Pace;

/// Figures of one codel.
#[derive(Debug)]
pub(crate) struct CodelFigures {
    pub(crate) durations: Histogram,
    /// How often it returned what, by the slots of its [`Yields`].
    pub(crate) yielded: Box<[Counter]>,
    /// Calls that took longer than the codel's declared `wcet`.
    pub(crate) above_wcet: Counter,
}

impl CodelFigures {
    pub(crate) fn new(yields: &Yields) -> Self {
        Self {
            durations: Histogram::default(),
            yielded: (0..yields.slots()).map(|_| Counter::default()).collect(),
            above_wcet: Counter::default(),
        }
    }

    /// The codel returned this after so many nanoseconds.
    #[inline]
    pub(crate) fn returned(&self, yields: &Yields, returned: Returned, ns: u64) {
        self.durations.record(ns);
        if let Some(counter) = self.yielded.get(yields.slot(returned)) {
            counter.add(1);
        }
    }
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
