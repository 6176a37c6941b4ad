//! Statistics of an instance, its tasks and codels.

use crate::histogram::Durations;
use crate::running::RunningCodel;
use crate::unpaused::Unpaused;

/// Statistics of an instance.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// For each task, in order of declaration.
    pub tasks: Vec<TaskStatistics>,
    /// For each codel that ran at least once.
    pub codels: Vec<CodelStatistics>,
    /// Changes that watchers missed because they did not keep up.
    pub lost_changes: u64,
}

/// Statistics of a task.
#[derive(Clone, Debug)]
pub struct TaskStatistics {
    /// Name of the task.
    pub name: String,
    /// Time between its ticks, in nanoseconds; `None` for an aperiodic task.
    pub period_ns: Option<u64>,
    /// Whether its thread has a real-time priority.
    pub real_time: bool,
    /// Duration of work per tick or wake-up, including the cycle under way.
    pub cycles: Durations,
    /// Delay from the date of a tick to the start of work.
    pub lateness: Durations,
    /// Ticks missed because the task was still at work, or slept beyond the next one. While a codel
    /// does not return, they are counted as they pass.
    pub overruns: u64,
    /// The stuck codel that it is in, if there is one.
    pub stuck: Option<RunningCodel>,
    /// What keeps it from pausing, when it has been at work for long without being stuck.
    pub unpaused: Option<Unpaused>,
}

/// Statistics of a codel.
#[derive(Clone, Debug)]
pub struct CodelStatistics {
    /// Name of its C function.
    pub name: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// Durations of calls.
    pub durations: Durations,
    /// What it returned at least once, and how often: states as codels name them (`main`,
    /// `pause::main`), exceptions by their full names, `ok`, and `other` for all that it must not
    /// return.
    pub yielded: Vec<(String, u64)>,
    /// Its declared worst-case execution time (`wcet`), in nanoseconds.
    pub wcet_ns: Option<u64>,
    /// Calls that took longer than that.
    pub above_wcet: u64,
}

/// Histograms of a task: durations in nanoseconds, each the longest of its bucket, and how many.
#[derive(Clone, Debug)]
pub struct TaskHistograms {
    /// Name of the task.
    pub name: String,
    /// Time between its ticks, in nanoseconds; `None` for an aperiodic task.
    pub period_ns: Option<u64>,
    /// Duration of work per tick or wake-up, of completed cycles.
    pub cycles: Vec<(u64, u64)>,
    /// Delay from the date of a tick to the start of work.
    pub lateness: Vec<(u64, u64)>,
}
