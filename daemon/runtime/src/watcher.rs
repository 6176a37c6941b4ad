//! What happens inside an instance, for those who watch.

use genom_description::model::{ServiceIx, TaskIx};
/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// An activity was accepted.
    Accepted {
        /// Number that the client was told.
        activity: u32,
        /// Service that was requested.
        service: ServiceIx,
    },
    /// A place of an activity's marking moved, or paused. Told within a fraction of a second.
    Moved {
        /// Number of the activity that moved.
        activity: u32,
        /// The state it is in now, by rank in the component's states.
        state: usize,
        /// Whether it pauses before it runs.
        paused: bool,
    },
    /// An activity ended.
    Ended {
        /// Number that the client was told.
        activity: u32,
        /// Service that was requested.
        service: ServiceIx,
        /// Name of the exception it ended with; `None` for success.
        exception: Option<String>,
    },
    /// Ticks came while a task was still at work, or slept beyond the one before.
    Overrun {
        /// Task that was late.
        task: TaskIx,
        /// How many.
        ticks: u64,
    },
    /// A permanent activity ended with an exception: the component is to be shut down.
    Failed {
        /// Task whose permanent activity failed.
        task: TaskIx,
        /// Name of the exception.
        exception: String,
    },
}

/// Watches an instance.
pub trait Watcher: Send + Sync {
    /// Called by control threads, never by a task's thread; in order for each activity.
    ///
    /// When it does not keep up, [`Change::Moved`] and [`Change::Overrun`] are dropped and
    /// counted in [`Statistics::lost_changes`](crate::Statistics::lost_changes).
    fn changed(&self, change: &Change);
}
