//! How tasks of components fare, for middlewares whose tools show that.

use serde::{Deserialize, Serialize};

/// How a task of a component fares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// The component instance.
    pub instance: String,
    /// The task.
    pub task: String,
    /// Whether something is wrong.
    pub health: Health,
    /// What, in a few words.
    pub message: String,
    /// Figures, by their names with units.
    pub values: Vec<(String, String)>,
}

/// Whether something is wrong with a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Health {
    /// It works as described.
    Good,
    /// It missed periods since it was told last.
    Late,
    /// A codel has not returned for too long.
    Stuck,
}
