//! How late after its tick a task may be at each of its codels.
//!
//! Sums take it that whatever a codel may wait for begins just then. But another task that is in time
//! executes it in the cycle of its own tick, whose date is known, and has done so by some date at the
//! latest; and not while there are activities that its own one interrupts, and that interrupt it.

use std::cell::RefCell;
use std::collections::HashMap;

use genom_timing::common;

use super::contexts::{Adds, Contexts};
use super::walk::{Dates, Does, Enters, Latest, Walk};
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;

/// How long a cycle may get that begins with these activities; anything if it cannot be told.
pub(crate) type CycleLength<'a> = dyn Fn(&[(u16, Does)]) -> u64 + 'a;

/// Lists of activities whose cycles are walked through for one search: more would take too long.
const LISTS: usize = 5_000;
/// Ticks of a task, from one date at which all tick to the next.
const TICKS: u64 = 64;

impl System {
    /// The latest dates of the cycles of periodic tasks while requests are served, each task on a
    /// processor of its own; `None` for a task that may not be over by its next tick.
    pub(crate) fn latest(&self, times: &Times) -> Vec<Option<Latest>> {
        let mut known: Vec<Option<Latest>> = vec![None; self.periods.len()];
        let contexts = Contexts::new(self);
        let Some(linked) = self.linked(times, &contexts) else { return known };
        let facts = Facts::all(self, times, (&contexts, &linked));
        for _ in 0..=known.len() {
            let mut better = false;
            for task in 0..small(known.len()) {
                let index = usize::from(task);
                let period = self.periods[index].map_or(0, |own| own.period);
                let in_time = |found: &Latest| found.cycle < period;
                let ticks = |walks: &Walks<'_>| {
                    self.at_ticks(times, task, (&facts, &linked), &known, walks).filter(in_time)
                };
                let all = ticks(&|walk| walk.from(None));
                let found = all.or_else(|| ticks(&|walk| walk.each()));
                let before = known[index].as_ref();
                let sum =
                    |one: &Latest| one.left.iter().fold(one.cycle, |a, b| a.saturating_add(*b));
                if let Some(found) = found
                    && before.is_none_or(|before| sum(&found) < sum(before))
                {
                    (known[index], better) = (Some(found), true);
                }
            }
            if !better {
                break;
            }
        }
        known
    }

    /// For each task, what it may wait for; `None` if dates cannot be told.
    fn linked(&self, times: &Times, contexts: &Contexts) -> Option<Vec<Vec<u16>>> {
        // Events put places beside those that an activity has.
        let events = self.bounds.fire && !self.sinks.is_empty();
        let dated = !self.by_period && !events && self.starts_in_time(times, contexts);
        let all = 0..small(self.periods.len());
        dated.then(|| all.map(|task| contexts.linked(task, contexts.of(task))).collect())
    }

    /// What `then` makes of how long the cycles of a task get that begin with some activities.
    pub(crate) fn with_cycles<T>(
        &self,
        times: &Times,
        task: u16,
        known: &[Option<Latest>],
        then: impl FnOnce(&CycleLength<'_>) -> T,
    ) -> T {
        let contexts = Contexts::new(self);
        let Some(linked) = self.linked(times, &contexts) else { return then(&|_| u64::MAX) };
        let facts = Facts::all(self, times, (&contexts, &linked));
        let told: RefCell<HashMap<Vec<(u16, Does)>, u64>> = RefCell::default();
        then(&|runs| {
            let mut told = told.borrow_mut();
            if told.len() >= LISTS && !told.contains_key(runs) {
                return u64::MAX;
            }
            *told.entry(runs.to_vec()).or_insert_with_key(|runs| {
                let from = |walk: Walk<'_>| walk.from(Some(runs.clone()));
                let latest = self.at_ticks(times, task, (&facts, &linked), known, &from);
                latest.map_or(u64::MAX, |latest| latest.cycle)
            })
        })
    }

    /// Whether the first service interrupts the second one.
    pub(crate) fn interrupts(&self, service: u16, other: u16) -> bool {
        self.services[usize::from(service)].interrupts[usize::from(other)]
    }

    /// Whether activities of these services, in order of admission, may all have begun while those
    /// others of another task have: of two of which one interrupts the other one, that one was sent
    /// before (R12).
    pub(super) fn may_be_beside(&self, own: &[u16], others: &[u16]) -> bool {
        let all = || (0..own.len()).flat_map(|a| (0..others.len()).map(move |b| (a, b)));
        let before = || all().filter(|(a, b)| self.interrupts(own[*a], others[*b]));
        let after = || all().filter(|(a, b)| self.interrupts(others[*b], own[*a]));
        before().all(|(a, b)| after().all(|(c, d)| c > a || d < b))
    }

    /// The service whose activities execute a node, if no other ones do.
    fn activity_of(&self, node: u16) -> Option<u16> {
        let executes = |machine: &&crate::machines::Machine| {
            machine.codels.contains(&Some(node)) || machine.fetch == Some(node)
        };
        let mut all = self.machines.iter().filter(executes);
        all.next().filter(|_| all.next().is_none())?.service
    }

    /// From each tick that differs from others in where those of other tasks are.
    fn at_ticks(
        &self,
        times: &Times,
        task: u16,
        (facts, linked): (&[Facts<'_>], &[Vec<u16>]),
        known: &[Option<Latest>],
        walks: &Walks<'_>,
    ) -> Option<Latest> {
        let own = self.periods[usize::from(task)]?;
        let mut others = self.periods.iter().flatten();
        let all = others.try_fold(own.period, |all, one| common(all, one.period))?;
        let ticks = all / own.period;
        if ticks > TICKS {
            return None;
        }
        let mut latest: Option<Latest> = None;
        for tick in 0..ticks {
            // Later by what all have in common, so that nothing is below zero.
            let begins = own.delay + tick * own.period + all;
            let enters = |node: u16, dates: &Dates, runs: &[(u16, Does)]| {
                let service = |run: &(u16, Does)| self.machines[usize::from(run.0)].service;
                let all = runs.iter().filter_map(service).collect();
                let beside = runs.iter().filter(|(_, does)| *does != Does::Gone);
                let beside = beside.filter_map(service).collect();
                let arrival = Arrival { task, begins, dates, all, beside, facts, known };
                arrival.enters(node)
            };
            let found = walks(Walk::new(self, times, task, (&enters, linked), &[]))?;
            latest = Some(match latest {
                None => found,
                Some(mut all) => {
                    all.cycle = all.cycle.max(found.cycle);
                    all.left.iter_mut().zip(found.left).for_each(|(all, one)| *all = one.max(*all));
                    all
                }
            });
        }
        latest
    }
}

/// What is made of the cycles that one tick begins.
type Walks<'a> = dyn Fn(Walk<'_>) -> Option<Latest> + 'a;

/// A task that arrives at a node.
struct Arrival<'a> {
    task: u16,
    /// The date of its tick.
    begins: u64,
    dates: &'a Dates,
    /// Services of activities that it had at its tick, in order of admission.
    all: Vec<u16>,
    /// And of those that it has now.
    beside: Vec<u16>,
    facts: &'a [Facts<'a>],
    known: &'a [Option<Latest>],
}

impl Arrival<'_> {
    /// When it enters at the latest, from its tick on.
    fn enters(&self, node: u16) -> u64 {
        let system = self.facts[0].system;
        let date = self.begins.saturating_add(self.dates.now);
        let workers = system.bounds.requests;
        self.free(node, date, &mut vec![self.task], workers).max(date) - self.begins
    }

    /// When nobody is ahead any more of who has arrived at a node by this date. Who is ahead waits
    /// in turn, but for none of those who wait for him.
    fn free(&self, node: u16, date: u64, waiting: &mut Vec<u16>, workers: usize) -> u64 {
        let Facts { system, times, contexts, .. } = self.facts[0];
        let mut free = date;
        for (context, other) in contexts.rivals(node) {
            let left = workers - usize::from(workers > 0 && !system.is_task(*context));
            let may =
                if system.is_task(*context) { !waiting.contains(context) } else { workers > 0 };
            let activity = system.activity_of(*other);
            if !may || activity.is_some_and(|service| !self.may_be_there(service)) {
                continue;
            }
            let by_date = self.by_date(*context, *other, date);
            if by_date <= free {
                continue;
            }
            waiting.push(*context);
            let enters = self.free(*other, date, waiting, left);
            waiting.pop();
            let leaves = enters.saturating_add(times.of(*other).most.unwrap_or(0));
            free = free.max(leaves.min(by_date));
        }
        free
    }

    /// Whether another task has an activity of this service now. If it was sent before one that this
    /// task has, it was there at the tick.
    fn may_be_there(&self, service: u16) -> bool {
        let system = self.facts[0].system;
        let before = self.beside.iter().any(|one| system.interrupts(service, *one));
        system.may_be_beside(&[service], &self.beside)
            && (!before || system.may_be_beside(&[service], &self.all))
    }

    /// When a node has been left that a task with a period had arrived at by this date.
    fn by_date(&self, context: u16, node: u16, date: u64) -> u64 {
        let rival = usize::from(context);
        let system = self.facts[0].system;
        let known = self.known.get(rival).and_then(Option::as_ref);
        let period = system.periods.get(rival).copied().flatten();
        let (Some(known), Some(period)) = (known, period) else { return u64::MAX };
        // It is in the cycle of its last tick, if it is there at all.
        let tick = date - (date - period.delay) % period.period;
        let by_date = tick.saturating_add(known.left[usize::from(node)]);
        // From then on it has not waited for this task, which does not wait for itself.
        let alone = tick.max(self.begins.saturating_add(self.dates.left[rival]));
        let beside = if tick < self.begins { Vec::new() } else { self.beside.clone() };
        let left = self.facts[rival].left(node, self.task, beside);
        by_date.min(left.map_or(u64::MAX, |left| alone.saturating_add(left)))
    }
}

/// For each node of a task, for how long it may wait there.
type Waits = Vec<u64>;

type Beside = HashMap<(u16, Vec<u16>), Option<Latest>>;

/// What is known of a task whatever the dates are.
struct Facts<'a> {
    system: &'a System,
    times: &'a Times,
    linked: &'a [Vec<u16>],
    task: u16,
    contexts: &'a Contexts,
    /// For each other task, for how long this one waits if never for that one.
    without: Vec<Waits>,
    /// For another task and activities of it, the latest dates if this one never waits for it, and
    /// these are there in the whole cycle.
    beside: RefCell<Beside>,
}

impl<'a> Facts<'a> {
    fn all(
        system: &'a System,
        times: &'a Times,
        with: (&'a Contexts, &'a [Vec<u16>]),
    ) -> Vec<Self> {
        (0..small(with.1.len())).map(|task| Self::new(system, times, with, task)).collect()
    }

    fn new(
        system: &'a System,
        times: &'a Times,
        (contexts, linked): (&'a Contexts, &'a [Vec<u16>]),
        task: u16,
    ) -> Self {
        let without = |but: u16| waits(system, times, contexts, (task, but));
        Self {
            system,
            times,
            linked,
            task,
            contexts,
            without: (0..small(system.periods.len())).map(without).collect(),
            beside: RefCell::default(),
        }
    }

    /// How long after its tick it has left a node at the latest, if it waits for no node of another
    /// task, of which activities of these services are there all the time.
    fn left(&self, node: u16, but: u16, mut beside: Vec<u16>) -> Option<u64> {
        let own = || self.system.machines.iter().filter(|one| one.task == self.task);
        let own = || own().filter_map(|one| one.service);
        beside.retain(|one| {
            let interrupts = |other: u16| {
                self.system.interrupts(other, *one) || self.system.interrupts(*one, other)
            };
            own().any(interrupts)
        });
        let mut known = self.beside.borrow_mut();
        let latest = known.entry((but, beside)).or_insert_with_key(|(but, beside)| {
            let waits = &self.without[usize::from(*but)];
            let enters = |node: u16, dates: &Dates, _: &[(u16, Does)]| {
                dates.now.saturating_add(waits[usize::from(node)])
            };
            let with = (&enters as &Enters<'_>, self.linked);
            Walk::new(self.system, self.times, self.task, with, beside).from(None)
        });
        latest.as_ref().map(|latest| latest.left[usize::from(node)])
    }
}

fn waits(system: &System, times: &Times, contexts: &Contexts, (task, but): (u16, u16)) -> Waits {
    let mut all = vec![0; system.plan.nodes().len()];
    for &node in contexts.of(task) {
        let counts = (&|context: u16| context != but) as &dyn Fn(u16) -> bool;
        let ahead = contexts.ahead(system, times, (task, node), counts, Adds::Chain);
        all[usize::from(node)] = ahead.iter().map(|one| one.time).fold(0, u64::saturating_add);
    }
    all
}
