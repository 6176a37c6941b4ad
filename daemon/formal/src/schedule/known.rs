//! What is known of a task while the others are looked at, and why there is no bound.

use super::cycle::Cycle;
use genom_timing::Load;

/// What another task executes during a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Meanwhile {
    /// The task.
    pub of: String,
    /// Cycles of it, at most.
    pub cycles: u64,
    /// What each executes that is waited for, at most.
    pub each: u64,
}

/// Why a response has no bound below the period.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It may take this long, which is not less than the period.
    Late(u64),
    /// States follow each other without pause in a circle.
    Loop,
    /// This task shares its processors, has the same or a higher priority, and no bound itself.
    Preempted(String),
    /// This thread is not a real-time one: others have its processor for any time.
    NotRealTime(String),
}

/// A task before it is known what others cost it.
pub(super) struct Known {
    pub(super) task: u16,
    pub(super) load: Load,
    pub(super) cycle: Option<Cycle>,
    /// What is counted for the whole cycle.
    pub(super) meanwhile: Vec<Meanwhile>,
}
