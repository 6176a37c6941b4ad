//! What was found of the tasks of a component.

use super::contexts::{Adds, Ahead, Contexts};
use super::cycle::{Costs, Cycle, Cycles};
use super::known::{Cause, Known, Meanwhile};
use super::startup::Startup;
use super::window::Window;
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;
use genom_description::model::{Ix as _, TaskIx};
use genom_timing::{Load, alone, together};

/// What threads run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processors {
    /// A processor for each thread.
    Own,
    /// So many for all tasks of the component, by priority; who holds what another one waits for
    /// has its priority.
    Shared(u64),
}

/// What was found of the tasks of a component.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Periodic tasks in the model's order.
    pub tasks: Vec<Scheduled>,
    /// Tasks without period: nothing is due of them.
    pub others: Vec<String>,
}

/// A task that has a period. Times are in nanoseconds.
#[derive(Clone, Debug)]
pub struct Scheduled {
    /// Its name.
    pub name: String,
    /// Its period.
    pub period: u64,
    /// The longest time from a tick to the end of its cycle; or why there is no bound below the
    /// period.
    pub response: Result<u64, Cause>,
    /// The longest cycle if nobody has its processor: what it executes, and waits for.
    pub work: u64,
    /// What it executes in that cycle, in order.
    pub called: Vec<Called>,
    /// What it waits for in that cycle, where that is counted for the whole cycle: as much as others
    /// execute in that time.
    pub meanwhile: Vec<Meanwhile>,
    /// Tasks of the same or a higher priority that share its processors, with their work in each
    /// period.
    pub preempted_by: Vec<(String, u64)>,
    /// Codels, and the time below which each would have to stay so that the task is in time, the
    /// others as they are.
    pub needed: Vec<(String, u64)>,
}

/// A codel in a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Called {
    /// Its name, or that of the service whose data are transferred.
    pub codel: String,
    /// The activity that calls it; `None` for the permanent one.
    pub activity: Option<String>,
    /// Time that it takes at most.
    pub most: u64,
    /// What it may wait for before.
    pub waits: Vec<Waits>,
}

/// What a codel may wait for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Waits {
    /// The task, or the service that is requested.
    pub of: String,
    /// The codel that it may execute or wait for itself.
    pub codel: String,
    /// Time that it takes at most.
    pub most: u64,
}

impl System {
    /// Bounds the responses of all periodic tasks. `late` is how long after their dates cycles
    /// begin, in nanoseconds.
    #[must_use]
    pub fn schedule(&self, times: &Times, processors: Processors, late: u64) -> Schedule {
        let mut schedule = self.bounded(times, processors, late);
        self.advise(&mut schedule, times, processors, late);
        schedule
    }

    /// The same without what would have to change.
    pub(crate) fn bounded(&self, times: &Times, processors: Processors, late: u64) -> Schedule {
        let contexts = Contexts::new(self);
        let own = processors == Processors::Own;
        let mut known = self.cycles(times, &contexts, processors, late);
        let startup = Startup::new(self, times, &contexts, &known);
        if own && startup.is_regular(self) {
            Window::new(self, times, &contexts).narrow(&mut known);
        }
        let mut order: Vec<u16> = (0..small(known.len())).collect();
        order.sort_by_key(|task| self.priority(*task));
        let mut found: Vec<(u16, Scheduled)> = Vec::new();
        for task in order.into_iter().filter(|task| !self.is_aperiodic(*task)) {
            let response = self.response(&known, &found, task, processors);
            let response = if own {
                startup.longer(self, &known[usize::from(task)], response)
            } else {
                response
            };
            if let Ok(response) = response {
                known[usize::from(task)].load.response = response - late;
            }
            let one = self.told(&known, times, task, processors, response);
            found.push((task, one));
        }
        found.sort_by_key(|(task, _)| *task);
        let others = known.iter().filter(|one| self.is_aperiodic(one.task));
        let others = others.map(|one| self.task_name(one.task)).collect();
        Schedule { tasks: found.into_iter().map(|(_, one)| one).collect(), others }
    }

    /// Whether all first cycles are over before the first tick.
    pub(super) fn starts_in_time(&self, times: &Times, contexts: &Contexts) -> bool {
        let known = self.cycles(times, contexts, Processors::Own, 0);
        Startup::new(self, times, contexts, &known).is_regular(self)
    }

    /// The dearest cycle of each task.
    fn cycles(
        &self,
        times: &Times,
        contexts: &Contexts,
        processors: Processors,
        late: u64,
    ) -> Vec<Known> {
        let own = processors == Processors::Own;
        let adds = if own { Adds::Chain } else { Adds::All };
        // First cycles are looked at by themselves then.
        let cycles = if own { Cycles::Ticks } else { Cycles::All };
        let mut known: Vec<Known> = Vec::new();
        for (period, task) in self.periods.iter().zip(0u16..) {
            let counts = |context: u16| match processors {
                // What others of a higher priority hold is in what they take of the processor.
                Processors::Shared(1) => {
                    !self.is_task(context) || self.priority(context) > self.priority(task)
                }
                Processors::Own | Processors::Shared(_) => true,
            };
            let costs = || Costs::new(self, times, contexts, task, (&counts, adds));
            let cycle = period.and_then(|_| Cycle::new(self, task, costs(), cycles).ok());
            let work = cycle.as_ref().map_or(0, |cycle| cycle.cost);
            let period = period.map_or(0, |period| period.period);
            let load = Load { period, work, late, response: 0 };
            known.push(Known { task, load, cycle, meanwhile: Vec::new() });
        }
        known
    }

    fn response(
        &self,
        known: &[Known],
        found: &[(u16, Scheduled)],
        task: u16,
        processors: Processors,
    ) -> Result<u64, Cause> {
        let own = &known[usize::from(task)];
        if own.cycle.is_none() {
            return Err(Cause::Loop);
        }
        let Processors::Shared(count) = processors else {
            let all = own.load.work.saturating_add(own.load.late);
            return if all < own.load.period { Ok(all) } else { Err(Cause::Late(all)) };
        };
        let threads = std::iter::once(task).chain(self.higher(task));
        for one in threads.clone() {
            if !self.plan.component().tasks[TaskIx::new(one.into())].real_time {
                return Err(Cause::NotRealTime(self.task_name(one)));
            }
        }
        for one in self.higher(task) {
            let bounded = found.iter().find(|(other, _)| *other == one);
            // Of two with one priority, one is looked at first: its work counts, if it has a bound.
            let unknown = bounded.is_none() && known[usize::from(one)].cycle.is_none();
            if unknown || bounded.is_some_and(|(_, one)| one.response.is_err()) {
                return Err(Cause::Preempted(self.task_name(one)));
            }
        }
        let mut higher: Vec<Load> =
            self.higher(task).map(|one| known[usize::from(one)].load).collect();
        // Not known yet: no more than its period.
        higher.iter_mut().filter(|one| one.response == 0).for_each(|one| one.response = one.period);
        let response =
            if count == 1 { alone(own.load, &higher) } else { together(own.load, &higher, count) };
        response.ok_or(Cause::Late(own.load.period))
    }

    fn told(
        &self,
        known: &[Known],
        times: &Times,
        task: u16,
        processors: Processors,
        response: Result<u64, Cause>,
    ) -> Scheduled {
        let own = &known[usize::from(task)];
        let called = own.cycle.as_ref().map_or_else(Vec::new, |cycle| self.called(times, cycle));
        let shares = processors != Processors::Own;
        let higher = self.higher(task).filter(|_| shares);
        let preempted = higher.map(|one| (self.task_name(one), known[usize::from(one)].load.work));
        Scheduled {
            name: self.task_name(task),
            period: own.load.period,
            response,
            work: own.load.work,
            called,
            meanwhile: own.meanwhile.clone(),
            preempted_by: preempted.collect(),
            needed: Vec::new(),
        }
    }

    /// What is executed in a cycle, in order.
    pub(super) fn called(&self, times: &Times, cycle: &Cycle) -> Vec<Called> {
        let waits = |ahead: &Ahead| Waits {
            of: self.name_of(ahead.context),
            codel: self.node_name(ahead.node),
            most: ahead.time,
        };
        let mut called = Vec::new();
        for (machine, codels) in &cycle.ways {
            let activity = self.machines[usize::from(*machine)].service;
            called.extend(codels.iter().map(|codel| Called {
                codel: self.node_name(*codel),
                activity: activity.map(|service| self.service_name(service)),
                most: times.of(*codel).most.unwrap_or(0),
                waits: cycle.ahead[usize::from(*codel)].iter().map(waits).collect(),
            }));
        }
        called
    }

    /// Tasks of the same or a higher priority.
    fn higher(&self, task: u16) -> impl Iterator<Item = u16> + Clone + '_ {
        let all = 0..small(self.periods.len());
        all.filter(move |other| *other != task && self.priority(*other) <= self.priority(task))
    }

    /// 0 is the highest, 255 the lowest (genom3.md 7.4).
    pub(super) fn priority(&self, task: u16) -> u32 {
        let task = self.plan.component().tasks.get(TaskIx::new(task.into()));
        task.and_then(|task| task.priority).unwrap_or(255).min(255)
    }

    /// A task, or the service that a worker serves.
    fn name_of(&self, context: u16) -> String {
        if self.is_task(context) {
            self.task_name(context)
        } else {
            self.service_name(context - self.worker_context(0))
        }
    }
}
