//! Codels at work, as far as they keep others from working. Times are in nanoseconds.

use serde::{Deserialize, Serialize};

/// A codel that runs now.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RunningCodel {
    /// The codel.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// The task whose thread is in it; none when it serves a request.
    pub task: Option<String>,
    /// How long it has been running, in nanoseconds.
    pub for_ns: u64,
    /// Whether that is so long that it counts as stuck.
    pub stuck: bool,
}

/// A task whose cycle lasts although its codels return: they yield states without pause.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Unpaused {
    /// The task.
    pub task: String,
    /// Whether it misses ticks by that.
    pub periodic: bool,
    /// The codel that yielded a state without pause last.
    pub codel: String,
    /// Task or service the codel belongs to.
    pub owner: String,
    /// How long the cycle has lasted.
    pub for_ns: u64,
    /// How often a codel yielded a state without pause in it.
    pub steps: u64,
}

/// A task that keeps a processor and does not pause.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Spin {
    /// The task, and what it does instead of pausing.
    #[serde(flatten)]
    pub unpaused: Unpaused,
    /// Share of a processor that it got lately, from 0 to 1.
    pub processor: f64,
}
