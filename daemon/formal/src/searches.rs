//! Searches for a run in which a task is late, in parts of a component that is too large to be seen as a
//! whole.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use genom_timing::{Limits, Random, lengths};

use crate::codels::small;
use crate::property::needed;
use crate::schedule::{Latest, Processors, Scheduled};
use crate::services::Work;
use crate::system::System;
use crate::timed::{Potential, Steps, Times, seek, walks};

/// Zones of a search for a task that is late, at most.
const ZONES: usize = 1_000_000;
/// The part of the memory that walks may take.
const PART: usize = 8;
/// The shortest time that walks through one part take, as a part of the time for all.
const SHORTEST: u32 = 150;

impl System {
    /// A run in which a task is late, if one is found. It is looked for in two ways, of which each finds
    /// what the other one does not: step by step where most may come, and by random walks through many
    /// small parts. Both at once if there are two processors; on one, the walks have the last sixth of
    /// the time. Walks differ from round to round.
    pub(crate) fn late_run(
        &self,
        times: &Times,
        (task, sum): (u16, &Scheduled),
        known: &[Option<Latest>],
        (limits, round): (&Limits, u64),
    ) -> Option<Steps> {
        let (parts, over) = (self.parts(times, sum), AtomicBool::new(false));
        let walked = Limits { memory: limits.memory / PART, ..*limits };
        let searched = Limits { memory: limits.memory - walked.memory, ..*limits };
        let walks = |limits: &Limits| {
            let random = Random(0x9e37_79b9_7f4a_7c15 + round);
            self.walked(times, task, (&parts, known), (limits, random), &over)
        };
        let search = |limits: &Limits| {
            let begin = Instant::now();
            self.with_cycles(times, task, known, |longest| {
                parts.iter().zip(1..).find_map(|(part, number)| {
                    let limits = limits.share(begin, parts.len() - number);
                    let limits = Limits { states: limits.states.min(ZONES), ..limits };
                    seek(&limits, &Potential::new(part, times, task, longest)?, &over)
                })
            })
        };
        if thread::available_parallelism().is_ok_and(|processors| processors.get() > 1) {
            return thread::scope(|scope| {
                let walks = scope.spawn(|| walks(&walked));
                let found = search(&searched);
                over.store(found.is_some(), Ordering::Relaxed);
                found.or(walks.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            });
        }
        let begin = Instant::now();
        let found = search(&Limits { time: limits.time / 6 * 5, ..searched });
        found.or_else(|| walks(&walked.share(begin, 0)))
    }

    /// A run to a task that is late by walks through parts that differ at random: with the services in
    /// its dearest cycle, and some others, which may move what is waited for to another date.
    fn walked(
        &self,
        times: &Times,
        task: u16,
        (parts, known): (&[Self], &[Option<Latest>]),
        (limits, mut random): (&Limits, Random),
        over: &AtomicBool,
    ) -> Option<Steps> {
        let begin = Instant::now();
        let mut states = limits.states;
        let found = self.with_cycles(times, task, known, |longest| {
            lengths().find_map(|length| {
                let left = limits.share(begin, 0);
                if left.time.is_zero() || states == 0 || over.load(Ordering::Relaxed) {
                    return Some(None);
                }
                let part = self.varied(parts, &mut random);
                let time = left.time.min((limits.time / SHORTEST).saturating_mul(length));
                let Some(potential) = Potential::new(&part, times, task, longest) else {
                    return Some(None);
                };
                let limits = Limits { time, states, ..left };
                let found = walks(&limits, &potential, &mut random, over);
                found.map_err(|looked| states = states.saturating_sub(looked)).ok().map(Some)
            })?
        });
        over.fetch_or(found.is_some(), Ordering::Relaxed);
        found
    }

    /// One of the parts with few services, and others of this component; or that with all of them.
    fn varied(&self, parts: &[Self], random: &mut Random) -> Self {
        if random.below(4) == 0 {
            return parts[parts.len().saturating_sub(2)].clone();
        }
        let few = parts.len().saturating_sub(2).max(1);
        let mut part = parts[random.below(few)].clone();
        let (percent, any) = (10 * (1 + random.below(5)), random.below(8) == 0);
        for (at, client) in part.clients.iter_mut().enumerate() {
            let acts = any || self.services[at].machine.is_some();
            *client |= self.clients[at] && acts && random.below(100) < percent;
        }
        if random.below(3) == 0 {
            part.bounds = self.bounds;
        }
        part
    }

    /// Parts of the component that may show that a task is late: with the services in its dearest
    /// cycle, if it may be late with these alone; with those that it may wait for as well; then with
    /// all; then as the bounds say, with aborts and events. Where more can be waited for, there is
    /// more to look at before a cycle that is late without.
    fn parts(&self, times: &Times, task: &Scheduled) -> Vec<Self> {
        let services = || 0..small(self.services.len());
        let called = || task.called.iter();
        let named = |service: &u16| {
            let name = Some(self.service_name(*service));
            called().any(|one| one.activity == name)
        };
        let own: Vec<u16> = services().filter(named).collect();
        let mut meant = own.clone();
        for one in called() {
            for waits in &one.waits {
                meant.extend(services().filter(|service| self.executes(*service, &waits.codel)));
            }
        }
        for other in &task.meanwhile {
            meant.extend(services().filter(|service| self.runs_in(*service, &other.of)));
        }
        let needed = |services: Vec<u16>| -> Vec<u16> {
            services.into_iter().flat_map(|service| needed(self, service)).collect()
        };
        // Of some activities the dearest cycle has several.
        let codels: Vec<(&Option<String>, &String)> =
            called().map(|one| (&one.activity, &one.codel)).collect();
        let several = codels.iter().enumerate().any(|(at, one)| codels[..at].contains(one));
        let instances = if several { self.bounds.instances } else { 1 };
        let bounds = crate::Bounds { abort: false, fire: false, instances, ..self.bounds };
        let few = |mut part: Self| {
            part.bounds = bounds;
            part
        };
        let alone = few(self.slice(&needed(own)));
        let sums = alone.bounded(times, Processors::Own, 0);
        let late = |sum: &Scheduled| sum.name == task.name && sum.response.is_err();
        let alone = sums.tasks.iter().any(late).then_some(alone);
        let others = [few(self.slice(&needed(meant))), few(self.clone()), self.clone()];
        alone.into_iter().chain(others).collect()
    }

    /// Whether a service, or its activity, executes a codel of this name.
    fn executes(&self, service: u16, codel: &str) -> bool {
        let facts = &self.services[usize::from(service)];
        let machine = facts.machine.map(|machine| &self.machines[usize::from(machine)]);
        let states = machine.iter().flat_map(|machine| machine.codels.iter().flatten());
        let work = facts.work.iter().filter_map(|work| match work {
            Work::Codel(node) | Work::Transfer(node) => Some(node),
            Work::Abort => None,
        });
        states.chain(work).any(|node| self.node_name(*node) == codel)
    }

    /// Whether the activity of a service is one of this task.
    fn runs_in(&self, service: u16, task: &str) -> bool {
        let machine = self.services[usize::from(service)].machine;
        let machine = machine.map(|machine| &self.machines[usize::from(machine)]);
        machine.is_some_and(|machine| self.task_name(machine.task) == task)
    }
}
