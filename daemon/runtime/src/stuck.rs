//! Codels that run now, which of them count as stuck, and what they hold up.
//!
//! All of it is read from outside, without help of the threads that run them.

use std::fmt;
use std::time::{Duration, Instant};

use genom_description::model::{Component, Owner};
use serde::Serialize;

use crate::body::Body;
use crate::clock::{monotonic, nanos};
use crate::engine::{Engine, lock};
use crate::plan::owner_name;

/// Periods that a codel of a periodic task may take before it counts as stuck.
const PERIODS: u64 = 5;
/// A codel of a periodic task is not stuck before this, however short its period.
const PERIODIC: u64 = 1_000_000_000;
/// How long others may have to wait behind somebody who excludes everything and cannot yet.
const TURN: Duration = Duration::from_millis(20);
/// Between two looks at a codel that has run for longer: nobody tells when it returns.
const LOOK: Duration = Duration::from_millis(2);

/// A codel that runs now.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunningCodel {
    /// Its name.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// The task whose thread is in it; `None` when it serves a request.
    pub task: Option<String>,
    /// How long it has been running.
    pub for_ns: u64,
    /// Whether that is so long that it counts as stuck.
    pub stuck: bool,
    /// Its rank in the model, and the context that it runs in.
    #[serde(skip)]
    pub(crate) place: (usize, usize),
    /// Monotonic date of its call: with the context, the call's identity.
    #[serde(skip)]
    since: u64,
}

impl RunningCodel {
    /// What distinguishes this call from all others of the instance.
    #[must_use]
    pub fn call(&self) -> (usize, u64) {
        (self.place.1, self.since)
    }
}

impl fmt::Display for RunningCodel {
    /// `codel NAME of OWNER, for 12 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "codel {} of {}, for {}", self.codel, self.owner, seconds(self.for_ns))
    }
}

/// A time as people say it: `12 s`, `3.2 s`.
#[must_use]
#[allow(clippy::cast_precision_loss, reason = "two digits are shown")]
pub fn seconds(ns: u64) -> String {
    match ns {
        0..10_000_000_000 => format!("{:.1} s", ns as f64 / 1e9),
        _ => format!("{} s", ns / 1_000_000_000),
    }
}

/// Something had to wait for a codel that does not return, and was given up; nothing was done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{instance} is held up{}", tell(.by.as_deref()))]
pub struct HeldUp {
    /// The instance.
    pub instance: String,
    /// What holds it up; `None` when codels came and went all the time.
    pub by: Option<Box<RunningCodel>>,
}

fn tell(by: Option<&RunningCodel>) -> String {
    match by {
        Some(codel) => {
            let (name, owner) = (&codel.codel, &codel.owner);
            format!(": codel {name} of {owner} has been running for {}", seconds(codel.for_ns))
        }
        None => ": its codels leave no moment between them".to_owned(),
    }
}

impl Engine {
    /// Codels that run now, by context: tasks first.
    pub(crate) fn running_codels(&self) -> Vec<RunningCodel> {
        let now = monotonic();
        let contexts = 0..self.shared.outside_context();
        contexts.filter_map(|context| self.running_codel(context, now)).collect()
    }

    /// The one that a task's thread is in.
    pub(crate) fn codel_of_task(&self, task: usize) -> Option<RunningCodel> {
        self.running_codel(task, monotonic())
    }

    fn running_codel(&self, context: usize, now: u64) -> Option<RunningCodel> {
        let (rank, since) = self.shared.at_work[context].look()?;
        let model: &Component = self.shared.plan.component();
        let codel = model.codels.get(rank)?;
        let for_ns = now.saturating_sub(since);
        Some(RunningCodel {
            codel: codel.name.clone(),
            owner: owner_name(model, codel.owner).to_owned(),
            task: model.tasks.get(context).map(|task| task.name.clone()),
            for_ns,
            stuck: for_ns > self.stuck_limit(rank, context),
            place: (rank, context),
            since,
        })
    }

    /// How long a codel may run in a context before it counts as stuck.
    fn stuck_limit(&self, codel: usize, context: usize) -> u64 {
        // One that says how long it takes is believed.
        let stated = self.shared.plan.component().codels[codel].wcet.map_or(0, nanos);
        self.patience_with(context).max(stated)
    }

    /// How long a context, that of a task or another one, may be at work without a word.
    pub(crate) fn patience_with(&self, context: usize) -> u64 {
        let others = nanos(self.stuck_after);
        let timing = self.shared.tasks.get(context).and_then(|task| task.timing);
        timing.map_or(others, |timing| {
            timing.period.saturating_mul(PERIODS).max(PERIODIC.min(others))
        })
    }

    /// The codel that has run for longest of those that `concerns` picks.
    fn longest(&self, concerns: impl Fn(&RunningCodel) -> bool) -> Option<RunningCodel> {
        let all = self.running_codels().into_iter();
        all.filter(concerns).max_by_key(|codel| codel.for_ns)
    }

    /// Does `work` with all codels excluded, unless one does not return: then it gives up.
    ///
    /// While a codel runs that takes long, the others are not made to wait for this.
    pub(crate) fn exclusively<R>(&self, work: impl FnOnce(&dyn Body) -> R) -> Result<R, HeldUp> {
        let (shared, context) = (&self.shared, self.shared.outside_context());
        let node = |codel: &RunningCodel| shared.plan.nodes().codel(codel.place.0);
        let held_up =
            |by: Option<RunningCodel>| HeldUp { instance: self.name.clone(), by: by.map(Box::new) };
        // Each holder gives up in time.
        let _turn = lock(&self.everything);
        let end = Instant::now() + self.stuck_after;
        loop {
            let by = self.longest(|codel| shared.exclusion.is_excluded(node(codel)));
            let late = Instant::now() >= end;
            match by {
                Some(by) if by.stuck || late => return Err(held_up(Some(by))),
                // Nobody tells when it returns.
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
    pub(crate) fn holds_up_service(&self, service: usize) -> Option<HeldUp> {
        let plan = &self.shared.plan;
        let (nodes, model) = (plan.nodes(), &plan.component().services[service]);
        let ours = model.validates.iter().chain(&model.codels).map(|&codel| nodes.codel(codel));
        let ours: Vec<usize> = ours.chain([nodes.transfer(service)]).collect();
        // No worker is left for it.
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
