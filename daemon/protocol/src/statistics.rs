//! Statistics of the tasks and codels of a component. Times are in nanoseconds.

use serde::{Deserialize, Serialize};

use crate::{RunningCodel, Unpaused};

/// Statistics of a component.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Statistics {
    /// The tasks, in order of declaration.
    pub tasks: Vec<TaskStatistics>,
    /// The codels that ran at least once.
    pub codels: Vec<CodelStatistics>,
    /// Changes that were not reported because they came too fast.
    pub lost_changes: u64,
}

/// Statistics of a task.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskStatistics {
    /// Name of the task.
    pub name: String,
    /// Its period; absent if it is aperiodic.
    pub period_ns: Option<u64>,
    /// Whether its thread has real-time priority; the system may have refused it.
    pub real_time: bool,
    /// Execution time per tick or wake-up. The present cycle is included with the time it has taken
    /// so far.
    pub cycles: Durations,
    /// Time from the date of a tick to the start of its execution.
    pub lateness: Durations,
    /// Missed ticks: those that came while the task was still running, or that were slept over.
    /// They are counted as they come, even while a codel does not return.
    pub overruns: u64,
    /// The codel that the task is stuck in, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck: Option<RunningCodel>,
    /// Set if the task has been in one cycle for long without being stuck: its codels yield states
    /// without pause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unpaused: Option<Unpaused>,
}

/// Statistics of a codel.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CodelStatistics {
    /// Name of the codel.
    pub name: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// Execution times of the codel.
    pub durations: Durations,
    /// What it returned at least once.
    #[serde(default)]
    pub yielded: Vec<Yielded>,
    /// Its declared worst-case execution time.
    pub wcet_ns: Option<u64>,
    /// Calls that took longer than that.
    pub above_wcet: u64,
}

/// Something that a codel returned, and how often.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Yielded {
    /// A state as codels name it (`main`, `pause::main`), the full name of an exception, `ok`, or
    /// `other` for all that the codel must not return.
    pub event: String,
    /// How often.
    pub count: u64,
}

/// Statistics of a duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Durations {
    /// Number of measurements.
    pub count: u64,
    /// The last one.
    pub last_ns: u64,
    /// The mean.
    pub mean_ns: u64,
    /// The median.
    pub p50_ns: u64,
    /// The 99th percentile.
    pub p99_ns: u64,
    /// The minimum; 0 when there is no measurement.
    #[serde(default)]
    pub min_ns: u64,
    /// The maximum.
    pub max_ns: u64,
}

/// How often the tasks of a component took how long, since it started.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Histograms {
    /// The tasks, in order of declaration.
    pub tasks: Vec<TaskHistograms>,
}

/// Histograms of a task.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskHistograms {
    /// Name of the task.
    pub name: String,
    /// Its period; absent if it is aperiodic.
    pub period_ns: Option<u64>,
    /// Execution time per tick or wake-up.
    pub cycles: Vec<Bucket>,
    /// Time from the date of a tick to the start of its execution.
    pub lateness: Vec<Bucket>,
}

/// Durations in one bucket of a histogram; buckets are an eighth of a power of two wide, and empty
/// ones are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Bucket {
    /// Longest duration that it has, in nanoseconds.
    pub most_ns: u64,
    /// How many it has.
    pub count: u64,
}
