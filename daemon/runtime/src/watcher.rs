//! Changes inside an instance, for watchers.

use genom_description::model::{ServiceIx, StateIx, TaskIx};

use crate::rules::Violation;

/// A change inside an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// An activity was accepted.
    Accepted {
        /// Id of the activity.
        activity: u32,
        /// The service.
        service: ServiceIx,
    },
    /// A token of an activity moved to a state, or paused. Reported within a fraction of a second.
    Moved {
        /// Id of the activity.
        activity: u32,
        /// The new state.
        state: StateIx,
        /// Whether it pauses before its codel runs.
        paused: bool,
    },
    /// An activity ended.
    Ended {
        /// Id of the activity.
        activity: u32,
        /// The service.
        service: ServiceIx,
        /// Name of the exception; `None` for success.
        exception: Option<String>,
    },
    /// A task missed ticks because it was still at work, or slept beyond the next one.
    Overrun {
        /// The task.
        task: TaskIx,
        /// Number of ticks missed.
        ticks: u64,
    },
    /// A rule was broken that the instance is supervised by.
    Violated(Violation),
    /// A permanent activity ended with an exception: the component will be shut down.
    Failed {
        /// The task of the permanent activity.
        task: TaskIx,
        /// Name of the exception.
        exception: String,
    },
}

/// Receives the changes inside an instance.
pub trait Watcher: Send + Sync {
    /// Called by control threads and by the caller of
    /// [`Instance::supervise`](crate::Instance::supervise), never by a task's thread; in order for
    /// each activity.
    ///
    /// If the watcher does not keep up, [`Change::Moved`] and [`Change::Overrun`] are dropped and
    /// counted in [`Statistics::lost_changes`](crate::Statistics::lost_changes).
    fn changed(&self, change: &Change);
}
