//! Tasks that are at work for long although their codels return: one yields states without pause
//! again and again.
//!
//! Whether that keeps a processor or waits for data within its codels is not known here.

use genom_description::model::{Component, Ix as _, TaskIx};

use crate::engine::Engine;
use crate::plan::owner_name;

/// A task whose cycle lasts although codels return.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unpaused {
    /// Name of the task at work.
    pub task: String,
    /// Whether it misses ticks by that.
    pub periodic: bool,
    /// The codel that yielded a state without pause last.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// How long the cycle has lasted.
    pub for_ns: u64,
    /// Times a codel yielded a state without pause in it.
    pub steps: u64,
    /// The system's number of the task's thread; `None` where it is not known.
    pub thread: Option<u32>,
    /// Rank of the task, and the date at which the cycle began: with the instance, its identity.
    pub cycle: (TaskIx, u64),
}

impl Engine {
    /// Tasks whose cycle lasts for longer than a codel may take, and that are stuck in none.
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
