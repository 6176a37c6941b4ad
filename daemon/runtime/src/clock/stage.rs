//! A clock on which codels take time, since whoever moves it also says when threads go on.
//!
//! Threads run the tasks as in real time. They ask before each pass, and scripted codels may ask
//! before they return; so one that lets them go on one after another gets the same run each time.

use std::fmt;
use std::sync::Weak;

/// Why a thread waits for its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// The task with this index makes its next pass.
    Pass {
        /// Index of the task.
        task: usize,
        /// The date at which the pass is due; `None` until something happens in the component.
        due: Option<u64>,
    },
    /// Control collects what tasks have ended.
    Control,
}

/// Moves the clock of an instance, and lets its threads go on.
pub trait Stage: fmt::Debug + Send + Sync {
    /// The current date, in nanoseconds.
    fn now(&self) -> u64;

    /// An instance begins. Before that none of its threads waits.
    fn enters(&self, instance: Weak<dyn OnStage>);

    /// Returns when the calling thread may go on.
    fn wait(&self, turn: Turn);
}

/// An instance, as the stage sees it.
pub trait OnStage: Send + Sync {
    /// Contexts that wait for codels of others, and cannot go on until one of these returns.
    fn blocked(&self) -> Vec<usize>;

    /// Requests that are being served, or are about to be.
    fn serving(&self) -> usize;

    /// Ticks that each task has missed by now, in the order of tasks.
    fn missed(&self) -> Vec<u64>;
}
