//! Tasks of several components on the processors of one machine.
//!
//! A task may run on some processors only. It is in time if it is on a part of them, looked at as a
//! machine of its own that has all tasks that may run on any of the part: Gujarati, Cerqueira,
//! Brandenburg, Schedulability Analysis of the Linux Push and Pull Scheduler with Arbitrary Processor
//! Affinities, 2013. Each single processor of a task is tried, and all of them together.

use genom_description::model::{Ix as _, TaskIx};

use super::contexts::{Adds, Contexts};
use super::cycle::{Costs, Cycle, Cycles};
use super::known::Cause;
use super::report::Scheduled;
use crate::system::System;
use crate::timed::Times;
use genom_timing::{Load, alone, together};

/// A component on a machine.
#[derive(Clone, Debug)]
pub struct Placed<'a> {
    /// Name of the instance.
    pub name: String,
    /// What it can do.
    pub system: &'a System,
    /// The times of its codels, all of them bounded.
    pub times: Times,
    /// Its tasks, in the model's order.
    pub threads: Vec<Threads>,
}

/// Where a task may run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Threads {
    /// Numbers of processors; empty for any.
    pub cpus: Vec<usize>,
    /// How late its cycles begin, in nanoseconds.
    pub late: u64,
}

/// Components on the processors of one machine.
#[derive(Clone, Debug)]
pub struct Machine<'a> {
    /// How many processors it has, with numbers from 0.
    pub processors: usize,
    /// The components.
    pub components: Vec<Placed<'a>>,
}

/// What was found of a task on a machine.
#[derive(Clone, Debug)]
pub struct OnMachine {
    /// Name of the instance.
    pub component: String,
    /// Processors on which it is in time, or may be late.
    pub cpus: Vec<usize>,
    /// The task; tasks that preempt it are named `COMPONENT/TASK`.
    pub task: Scheduled,
}

/// A task, with what may be changed of it.
#[derive(Clone, Debug)]
pub(super) struct Job {
    /// Place of its component.
    pub(super) of: usize,
    pub(super) task: u16,
    /// `None` without period.
    pub(super) period: Option<u64>,
    pub(super) priority: u32,
    pub(super) real_time: bool,
    pub(super) cpus: Vec<usize>,
    pub(super) late: u64,
}

impl Machine<'_> {
    /// All tasks, in the order of components and tasks.
    pub(super) fn jobs(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        for (of, placed) in self.components.iter().enumerate() {
            let model = placed.system.plan().component();
            for (period, task) in placed.system.periods().iter().zip(0u16..) {
                let threads = placed.threads.get(usize::from(task)).cloned().unwrap_or_default();
                let any = || (0..self.processors.max(1)).collect();
                jobs.push(Job {
                    of,
                    task,
                    period: period.map(|period| period.period),
                    priority: placed.system.priority(task),
                    real_time: model.tasks[TaskIx::new(task.into())].real_time,
                    cpus: if threads.cpus.is_empty() { any() } else { threads.cpus },
                    late: threads.late,
                });
            }
        }
        jobs
    }

    /// The longest times from ticks to the ends of their cycles, of all tasks with a period.
    #[must_use]
    pub fn schedule(&self) -> Vec<OnMachine> {
        self.bounded(&self.jobs())
    }

    pub(super) fn bounded(&self, jobs: &[Job]) -> Vec<OnMachine> {
        let contexts = self.components.iter().map(|placed| Contexts::new(placed.system)).collect();
        let mut known =
            Known { machine: self, jobs, contexts, found: jobs.iter().map(|_| None).collect() };
        let mut order: Vec<usize> = (0..jobs.len()).collect();
        order.sort_by_key(|job| jobs[*job].priority);
        for job in order.into_iter().filter(|job| jobs[*job].period.is_some()) {
            known.found[job] = Some(known.best(job));
        }
        known.found.into_iter().flatten().map(|(told, _)| told).collect()
    }

    /// Name of a task among those of all components.
    pub(super) fn name(&self, job: &Job) -> String {
        let placed = &self.components[job.of];
        format!("{}/{}", placed.name, placed.system.task_name(job.task))
    }
}

/// What is known so far: that of tasks of higher priority comes first.
struct Known<'a> {
    machine: &'a Machine<'a>,
    jobs: &'a [Job],
    contexts: Vec<Contexts>,
    /// For each task what is told of it, and its response, if it has a bound.
    found: Vec<Option<(OnMachine, Option<u64>)>>,
}

impl Known<'_> {
    /// The best of what is known of a task on parts of its processors.
    fn best(&self, job: usize) -> (OnMachine, Option<u64>) {
        let own = &self.jobs[job];
        let rank = |told: &OnMachine| match &told.task.response {
            Ok(response) => (0, *response),
            Err(Cause::Late(least)) => (1, *least),
            Err(_) => (2, 0),
        };
        let mut best = self.on(job, own.cpus.clone());
        if own.cpus.len() > 1 {
            for cpu in &own.cpus {
                let other = self.on(job, vec![*cpu]);
                if rank(&other) < rank(&best) {
                    best = other;
                }
            }
        }
        let response = best.task.response.as_ref().ok().copied();
        (best, response)
    }

    /// The dearest cycle of a task, if only these processors are looked at. On a single one, what
    /// tasks of a higher priority execute that run nowhere else is not waited for: it is in what they
    /// take of the processor.
    fn cycle(&self, job: usize, cpus: &[usize]) -> Option<Cycle> {
        let own = &self.jobs[job];
        let placed = &self.machine.components[own.of];
        let counts = |context: u16| {
            let of_task = |other: &&Job| other.of == own.of && other.task == context;
            let task = self.jobs.iter().find(of_task).filter(|_| placed.system.is_task(context));
            let preempts = |task: &Job| {
                let here = cpus.len() == 1 && task.cpus == cpus;
                here && task.real_time && task.priority <= own.priority
            };
            !task.is_some_and(preempts)
        };
        let contexts = &self.contexts[own.of];
        let counts: (&dyn Fn(u16) -> bool, Adds) = (&counts, Adds::All);
        let costs = Costs::new(placed.system, &placed.times, contexts, own.task, counts);
        Cycle::new(placed.system, own.task, costs, Cycles::All).ok()
    }

    /// What is known of a task on these processors, all of which it may run on.
    fn on(&self, job: usize, cpus: Vec<usize>) -> OnMachine {
        let own = &self.jobs[job];
        let placed = &self.machine.components[own.of];
        let higher: Vec<usize> = (0..self.jobs.len())
            .filter(|other| {
                let task = &self.jobs[*other];
                let meets = task.cpus.iter().any(|cpu| cpus.contains(cpu));
                *other != job && task.real_time && task.priority <= own.priority && meets
            })
            .collect();
        let (load, cycle) = self.load(job, &cpus);
        let loads: Vec<(usize, Load)> =
            higher.iter().map(|other| (*other, self.load(*other, &cpus).0)).collect();
        let response = match &cycle {
            None => Err(Cause::Loop),
            Some(_) if !own.real_time => Err(Cause::NotRealTime(self.machine.name(own))),
            Some(_) => self.response(load, &loads, cpus.len()),
        };
        let name = |other: usize| self.machine.name(&self.jobs[other]);
        let called = cycle.map(|cycle| placed.system.called(&placed.times, &cycle));
        let task = Scheduled {
            name: placed.system.task_name(own.task),
            period: load.period,
            response,
            work: load.work,
            called: called.unwrap_or_default(),
            meanwhile: Vec::new(),
            preempted_by: loads.iter().map(|(other, load)| (name(*other), load.work)).collect(),
            needed: Vec::new(),
        };
        OnMachine { component: placed.name.clone(), cpus, task }
    }

    /// A task as the recurrences see it on these processors, with its dearest cycle.
    fn load(&self, job: usize, cpus: &[usize]) -> (Load, Option<Cycle>) {
        let own = &self.jobs[job];
        let cycle = self.cycle(job, cpus);
        let work = cycle.as_ref().map_or(0, |cycle| cycle.cost);
        let period = own.period.unwrap_or(u64::MAX);
        let found = self.found[job].as_ref().and_then(|(_, response)| *response);
        // Not known yet: no more than its period.
        let response = found.map_or(period, |response| response - own.late);
        (Load { period, work, late: own.late, response }, cycle)
    }

    fn response(
        &self,
        own: Load,
        higher: &[(usize, Load)],
        processors: usize,
    ) -> Result<u64, Cause> {
        for (other, load) in higher {
            let job = &self.jobs[*other];
            let unbounded = self.found[*other].as_ref().is_some_and(|(_, known)| known.is_none());
            // Of two with one priority, one is looked at first: its work counts, if it has a bound.
            if job.period.is_none() || unbounded || self.cycle(*other, &[]).is_none() {
                return Err(Cause::Preempted(self.machine.name(job)));
            }
            debug_assert!(load.period > 0);
        }
        let loads: Vec<Load> = higher.iter().map(|(_, load)| *load).collect();
        let count = u64::try_from(processors).unwrap_or(u64::MAX);
        let response = if count == 1 { alone(own, &loads) } else { together(own, &loads, count) };
        let least = own.work.saturating_add(own.late).max(own.period);
        response.ok_or(Cause::Late(least))
    }
}
