//! An instance, as the thread that executes many of them sees it.

use std::sync::Arc;

use crate::running::RunningCodel;

/// What is left to do for an instance besides its tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// More, at once.
    More,
    /// Nothing before this date, unless somebody asks.
    At(u64),
    /// Nothing until somebody asks.
    Idle,
    /// It has stopped: its tasks are released.
    Over,
}

/// An instance whose tasks share a thread with others.
pub(crate) trait Member: Send + Sync {
    /// Does control work: collects results, serves at most one request, advances a shutdown.
    fn turn(self: Arc<Self>) -> Turn;
    /// Its tasks were released; no codel of it runs any more on the shared thread.
    fn left(&self);
    /// Its codels that run now, with owners named `INSTANCE/OWNER`.
    fn running(&self) -> Vec<RunningCodel>;
}
