//! What an instance tells of its tasks and codels.

use crate::histogram::Durations;
use crate::running::RunningCodel;
use crate::unpaused::Unpaused;

/// Statistics of an instance.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// By task, in order of declaration.
    pub tasks: Vec<TaskStatistics>,
    /// By codel, those that ran at least once.
    pub codels: Vec<CodelStatistics>,
    /// Changes that watchers missed because they came too fast.
    pub lost_changes: u64,
}

/// Statistics of a task.
#[derive(Clone, Debug)]
pub struct TaskStatistics {
    /// Name of the task.
    pub name: String,
    /// Time between its ticks, in nanoseconds; `None` for an aperiodic task.
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
    pub stuck: Option<RunningCodel>,
    /// What it does instead of pausing, when it has been at work for long and is not stuck.
    pub unpaused: Option<Unpaused>,
}

/// Statistics of a codel.
#[derive(Clone, Debug)]
pub struct CodelStatistics {
    /// Name of its C function.
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
