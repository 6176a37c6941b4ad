//! Tasks whose cycles last for long although their codels return: one yields states without pause
//! over and over.
//!
//! Whether that uses a processor or waits for data inside the codels is not known here.

use genom_description::model::{Component, Ix as _, TaskIx};

use crate::engine::Engine;
use crate::plan::owner_name;

/// A task whose cycle goes on although codels return.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unpaused {
    /// Name of the task at work.
    pub task: String,
    /// Whether it is periodic, and so misses ticks.
    pub periodic: bool,
    /// The last codel that yielded a state without pause.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// Duration of the cycle so far, in nanoseconds.
    pub for_ns: u64,
    /// How often a codel yielded a state without pause in this cycle.
    pub steps: u64,
    /// Thread id of the task; `None` if unknown.
    pub thread: Option<u32>,
    /// Index of the task, and date of the cycle's begin: together they identify the cycle in the
    /// instance.
    pub cycle: (TaskIx, u64),
}

impl Engine {
    /// Tasks whose cycle has lasted longer than a codel may take, and that are not stuck in one.
    pub(crate) fn unpaused(&self) -> Vec<Unpaused> {
        let now = self.shared.clock.now();
        self.shared.tasks.places().filter_map(|task| self.unpaused_task(task, now)).collect()
    }

    pub(crate) fn unpaused_task(&self, task: TaskIx, now: u64) -> Option<Unpaused> {
        let shared = &self.shared.tasks[task];
        let lasting = shared.figures.cycles.lasting(now)?;
        let model: &Component = self.shared.plan.component();
        let codel = model.codels.get(lasting.codel).filter(|_| lasting.steps > 0)?;
        let stuck = || self.codel_of_task(task).is_some_and(|codel| codel.stuck);
        if lasting.for_ns <= self.patience_with(task.index()) || stuck() {
            return None;
        }
        Some(Unpaused {
            task: model.tasks[task].name.clone(),
            periodic: shared.timing.is_some(),
            codel: codel.name.clone(),
            owner: owner_name(model, codel.owner).to_owned(),
            for_ns: lasting.for_ns,
            steps: lasting.steps,
            thread: shared.thread_number(),
            cycle: (task, lasting.began),
        })
    }
}
