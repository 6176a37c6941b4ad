//! Running codels, and tasks whose codels never pause. Times are in nanoseconds.

use serde::{Deserialize, Serialize};

/// A codel that is running now.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RunningCodel {
    /// Name of the codel.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// The task whose thread runs it; absent if the control task runs it for a request.
    pub task: Option<String>,
    /// How long it has been running, in nanoseconds.
    pub for_ns: u64,
    /// Whether it counts as stuck (`stuck_after` in the configuration).
    pub stuck: bool,
}

/// A task that has been in one cycle for long although its codels return: they yield states without
/// pause.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Unpaused {
    /// Name of the task.
    pub task: String,
    /// Whether the task is periodic, so that it misses ticks.
    pub periodic: bool,
    /// The codel that last yielded a state without pause.
    pub codel: String,
    /// Task or service the codel belongs to.
    pub owner: String,
    /// How long the cycle has lasted, in nanoseconds.
    pub for_ns: u64,
    /// Number of times in this cycle that a codel yielded a state without pause.
    pub steps: u64,
}

/// A task that occupies a processor and never pauses.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Spin {
    /// The task and its codel.
    #[serde(flatten)]
    pub unpaused: Unpaused,
    /// Share of one processor that it used recently, from 0 to 1.
    pub processor: f64,
}
