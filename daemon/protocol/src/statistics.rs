//! Statistics of the tasks and codels of a component. Times are in nanoseconds.

use serde::{Deserialize, Serialize};

use crate::{RunningCodel, Unpaused};

/// Statistics of a component.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Statistics {
    /// By task, in order of declaration.
    pub tasks: Vec<TaskStatistics>,
    /// By codel, those that ran at least once.
    pub codels: Vec<CodelStatistics>,
    /// Changes that watchers missed because they came too fast.
    pub lost_changes: u64,
}

/// Statistics of a task.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskStatistics {
    /// The task.
    pub name: String,
    /// Its period; none of an aperiodic one.
    pub period_ns: Option<u64>,
    /// Whether its thread really has a real-time priority.
    pub real_time: bool,
    /// Time at work, per tick or wake-up; the one that it is at counts as long as it has lasted.
    pub cycles: Durations,
    /// Time from a tick's date to the start of work.
    pub lateness: Durations,
    /// Ticks that came while the task was still at work, or slept beyond the one before; those
    /// that come while a codel does not return count as they come.
    pub overruns: u64,
    /// The codel that it is stuck in, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stuck: Option<RunningCodel>,
    /// What it does instead of pausing, when it has been at work for long and is not stuck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unpaused: Option<Unpaused>,
}

/// Statistics of a codel.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CodelStatistics {
    /// The codel.
    pub name: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// Time in the codel.
    pub durations: Durations,
    /// Its stated worst-case execution time.
    pub wcet_ns: Option<u64>,
    /// Calls that took longer.
    pub above_wcet: u64,
}

/// Figures on a duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Durations {
    /// How many were measured.
    pub count: u64,
    /// The last one.
    pub last_ns: u64,
    /// Their mean.
    pub mean_ns: u64,
    /// Half were no longer than this.
    pub p50_ns: u64,
    /// 99 % were no longer than this.
    pub p99_ns: u64,
    /// The longest.
    pub max_ns: u64,
}
