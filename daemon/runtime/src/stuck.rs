//! Codels that run now, which of them count as stuck, and what they block.
//!
//! All of this is determined from outside, without help of the threads that run the codels.

use std::time::{Duration, Instant};

use genom_description::model::{CodelIx, Component, Ix as _, Owner, ServiceIx, TaskIx};

use crate::body::Body;
use crate::clock::{monotonic, nanos};
use crate::engine::Engine;
use crate::lock::lock;
use crate::plan::owner_name;
use crate::running::{HeldUp, RunningCodel};

/// Periods after which a codel of a periodic task counts as stuck.
const PERIODS: u64 = 5;
/// Nanoseconds before which no codel of a periodic task counts as stuck, however short its period.
const PERIODIC: u64 = 1_000_000_000;
/// How long an attempt to exclude everything may keep later arrivals waiting.
const TURN: Duration = Duration::from_millis(20);
/// Interval of polling while a codel runs longer than that: its return wakes nobody.
const LOOK: Duration = Duration::from_millis(2);

/// Nanoseconds after which a codel without `wcet` counts as stuck: `stuck_after`; in a task with this
/// period five of them, but at least the shorter of one second and `stuck_after`.
#[must_use]
pub fn patience(period: Option<u64>, stuck_after: u64) -> u64 {
    period
        .map_or(stuck_after, |period| period.saturating_mul(PERIODS).max(PERIODIC.min(stuck_after)))
}

impl Engine {
    /// Codels that run now, in the order of contexts: those of tasks first.
    pub(crate) fn running_codels(&self) -> Vec<RunningCodel> {
        let now = monotonic();
        let contexts = 0..self.shared.outside_context();
        contexts.filter_map(|context| self.running_codel(context, now)).collect()
    }

    /// The codel that a task's thread runs.
    pub(crate) fn codel_of_task(&self, task: TaskIx) -> Option<RunningCodel> {
        self.running_codel(task.index(), monotonic())
    }

    fn running_codel(&self, context: usize, now: u64) -> Option<RunningCodel> {
        let (ix, _, since) = self.shared.at_work[context].look()?;
        let model: &Component = self.shared.plan.component();
        let codel = model.codels.get(ix)?;
        let for_ns = now.saturating_sub(since);
        Some(RunningCodel {
            codel: codel.name.clone(),
            owner: owner_name(model, codel.owner).to_owned(),
            task: model.tasks.get(TaskIx::new(context)).map(|task| task.name.clone()),
            for_ns,
            stuck: for_ns > self.stuck_limit(ix, context),
            place: (ix, context),
            since,
        })
    }

    /// Nanoseconds after which a codel in a context counts as stuck.
    pub(crate) fn stuck_limit(&self, codel: CodelIx, context: usize) -> u64 {
        // A codel with a `wcet` counts as stuck only beyond it.
        let stated = self.shared.plan.component().codels[codel].wcet.map_or(0, nanos);
        self.patience_with(context).max(stated)
    }

    /// Nanoseconds after which work of a context counts as stuck.
    pub(crate) fn patience_with(&self, context: usize) -> u64 {
        let timing = self.shared.tasks.get(TaskIx::new(context)).and_then(|task| task.timing);
        patience(timing.map(|timing| timing.period), nanos(self.stuck_after))
    }

    /// The codel that has run for longest among those selected by `concerns`.
    pub(crate) fn longest(&self, concerns: impl Fn(&RunningCodel) -> bool) -> Option<RunningCodel> {
        let all = self.running_codels().into_iter();
        all.filter(concerns).max_by_key(|codel| codel.for_ns)
    }

    /// Runs `work` while no codel runs; gives up when a codel does not return in time.
    ///
    /// It asks for the exclusion only when no codel has been running for long: while it waits, all
    /// others have to wait too.
    pub(crate) fn exclusively<R>(&self, work: impl FnOnce(&dyn Body) -> R) -> Result<R, HeldUp> {
        let (shared, context) = (&self.shared, self.shared.outside_context());
        let node = |codel: &RunningCodel| shared.plan.nodes().codel(codel.place.0);
        let held_up =
            |by: Option<RunningCodel>| HeldUp { instance: self.name.clone(), by: by.map(Box::new) };
        // Bounded: each holder before this one gives up in time.
        let _turn = lock(&self.everything);
        let end = Instant::now() + self.stuck_after;
        loop {
            let by = self.longest(|codel| shared.exclusion.is_excluded(node(codel)));
            let late = Instant::now() >= end;
            match by {
                Some(by) if by.stuck || late => return Err(held_up(Some(by))),
                // Its return wakes nobody, so poll.
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

    /// The stuck codel that keeps requests of a service from being served, if there is one.
    pub(crate) fn holds_up_service(&self, service: ServiceIx) -> Option<HeldUp> {
        if let Some(executor) = &self.single {
            // Whichever codel it is, it has the thread that has to serve the request.
            let by = executor.running().filter(|codel| codel.stuck)?;
            return Some(HeldUp { instance: self.name.clone(), by: Some(Box::new(by)) });
        }
        let plan = &self.shared.plan;
        let (nodes, model) = (plan.nodes(), &plan.component().services[service]);
        let ours = model.validates.iter().chain(&model.codels).map(|&codel| nodes.codel(codel));
        let ours: Vec<usize> = ours.chain([nodes.transfer(service)]).collect();
        // All workers are busy.
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
