//! How tasks of components fare, and the processes that they are in, for middlewares whose tools
//! show that.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// How a part of a component fares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// The component instance.
    pub instance: String,
    /// What of it.
    pub of: Part,
    /// Whether something is wrong.
    pub health: Health,
    /// What, in a few words.
    pub message: String,
    /// Figures, by their names with units.
    pub values: Vec<(String, String)>,
}

impl Diagnosis {
    /// How often it is told how a component fares, as is usual on `/diagnostics` of ROS 2.
    pub const ROUND: Duration = Duration::from_secs(1);
}

/// A part of a component that can fare well or badly.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// A task, by its name.
    Task(String),
    /// The process that it is in, by the name of the cell. When that has ended, nothing of the
    /// component is open on any middleware, and another process tells so.
    Cell(String),
}

/// Whether something is wrong with a part of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Health {
    /// It works as described.
    Good,
    /// It missed periods since it was told last.
    Late,
    /// A codel has not returned for too long.
    Stuck,
    /// It ended, and nobody had asked it to.
    Ended,
}
