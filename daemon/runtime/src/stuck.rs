//! Codels that run now, which of them count as stuck, and what they hold up.
//!
//! All of it is read from outside, without help of the threads that run them.

use std::time::{Duration, Instant};

use genom_description::model::{Component, Ix as _, Owner, ServiceIx, TaskIx};

use crate::body::Body;
use crate::clock::{monotonic, nanos};
use crate::engine::Engine;
use crate::lock::lock;
use crate::plan::owner_name;
use crate::running::{HeldUp, RunningCodel};

/// Periods that a codel of a periodic task may take before it counts as stuck.
const PERIODS: u64 = 5;
/// A codel of a periodic task is not stuck before this, however short its period.
const PERIODIC: u64 = 1_000_000_000;
/// How long a thread that wants to exclude everything may keep later ones waiting behind it.
const TURN: Duration = Duration::from_millis(20);
/// Between two looks at a codel that has run for longer than that: its return wakes nobody.
const LOOK: Duration = Duration::from_millis(2);

impl Engine {
    /// Codels that run now, by context: tasks first.
    pub(crate) fn running_codels(&self) -> Vec<RunningCodel> {
        let now = monotonic();
        let contexts = 0..self.shared.outside_context();
        contexts.filter_map(|context| self.running_codel(context, now)).collect()
    }

    /// The one that a task's thread is in.
    pub(crate) fn codel_of_task(&self, task: TaskIx) -> Option<RunningCodel> {
        self.running_codel(task.index(), monotonic())
    }

    fn running_codel(&self, context: usize, now: u64) -> Option<RunningCodel> {
        let (rank, since) = self.shared.at_work[context].look()?;
        let model: &Component = self.shared.plan.component();
        let codel = model.codels.get(rank)?;
        let for_ns = now.saturating_sub(since);
        Some(RunningCodel {
            codel: codel.name.clone(),
            owner: owner_name(model, codel.owner).to_owned(),
            task: model.tasks.get(TaskIx::new(context)).map(|task| task.name.clone()),
            for_ns,
            stuck: for_ns > self.stuck_limit(rank, context),
            place: (rank, context),
            since,
        })
    }

    /// How long a codel may run in a context before it counts as stuck.
    fn stuck_limit(&self, codel: usize, context: usize) -> u64 {
        // A codel with a stated `wcet` is stuck only beyond it.
        let stated = self.shared.plan.component().codels[codel].wcet.map_or(0, nanos);
        self.patience_with(context).max(stated)
    }

    /// How long a context may be at work before it counts as stuck: `stuck_after`; for a periodic
    /// task five periods, but at least the shorter of one second and `stuck_after`.
    pub(crate) fn patience_with(&self, context: usize) -> u64 {
        let others = nanos(self.stuck_after);
        let timing = self.shared.tasks.get(TaskIx::new(context)).and_then(|task| task.timing);
        timing.map_or(others, |timing| {
            timing.period.saturating_mul(PERIODS).max(PERIODIC.min(others))
        })
    }

    /// The codel that has run for longest of those that `concerns` picks.
    fn longest(&self, concerns: impl Fn(&RunningCodel) -> bool) -> Option<RunningCodel> {
        let all = self.running_codels().into_iter();
        all.filter(concerns).max_by_key(|codel| codel.for_ns)
    }

    /// Does `work` while no codel runs; gives up when a codel does not return in time.
    ///
    /// It asks for the exclusion only when no long codel runs: who asks keeps all others waiting.
    pub(crate) fn exclusively<R>(&self, work: impl FnOnce(&dyn Body) -> R) -> Result<R, HeldUp> {
        let (shared, context) = (&self.shared, self.shared.outside_context());
        let node = |codel: &RunningCodel| shared.plan.nodes().codel(codel.place.0);
        let held_up =
            |by: Option<RunningCodel>| HeldUp { instance: self.name.clone(), by: by.map(Box::new) };
        // Waits at most as long as each holder before it, and each gives up in time.
        let _turn = lock(&self.everything);
        let end = Instant::now() + self.stuck_after;
        loop {
            let by = self.longest(|codel| shared.exclusion.is_excluded(node(codel)));
            let late = Instant::now() >= end;
            match by {
                Some(by) if by.stuck || late => return Err(held_up(Some(by))),
                // Its return wakes nobody: look again.
                Some(by) if u128::from(by.for_ns) > TURN.as_nanos() => {
                    std::thread::park_timeout(LOOK);
                }
                by => match shared.exclusion.enter_all(context, Some(TURN)) {
                    Some(_permit) => return Ok(work(shared.body.as_ref())),
                    None if late => return Err(held_up(by)),
                    None => {}
                },
            }
        }
    }

    /// What keeps requests of a service from being served, if it is a codel that is stuck.
    pub(crate) fn holds_up_service(&self, service: ServiceIx) -> Option<HeldUp> {
        let plan = &self.shared.plan;
        let (nodes, model) = (plan.nodes(), &plan.component().services[service]);
        let ours = model.validates.iter().chain(&model.codels).map(|&codel| nodes.codel(codel));
        let ours: Vec<usize> = ours.chain([nodes.transfer(service)]).collect();
        // All workers are taken.
        let full = self.lock().contexts.is_empty();
        let by = self.longest(|running| {
            let (codel, context) = running.place;
            let same = plan.component().codels[codel].owner == Owner::Service(service);
            let served = context >= self.shared.tasks.len();
            let excludes = |&node: &usize| nodes.conflicts(node).contains(&nodes.codel(codel));
            running.stuck && ((served && (same || full)) || ours.iter().any(excludes))
        })?;
        Some(HeldUp { instance: self.name.clone(), by: Some(Box::new(by)) })
    }
}
