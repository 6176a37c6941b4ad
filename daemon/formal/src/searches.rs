//! Searches for a run in which a task is late, in parts of a component that is too large to be seen as a
//! whole.

use std::num::NonZero;
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
/// Walks at the same time, at most.
const WALKERS: u8 = 4;
/// The part of the time that the search step by step has, if nobody finds a run before.
const SEARCHED: u32 = 6;
/// The shortest time that walks through one part take, as a part of the time for all.
const SHORTEST: u32 = 150;

impl System {
    /// A run in which a task is late, if one is found. It is looked for in two ways, of which each finds
    /// what the other one does not: step by step where most may come, and by random walks through many
    /// small parts. What the first way finds it mostly finds at once, so it has a part of the time of one
    /// processor, which walks then, too; all others, up to some, walk from the beginning on. Walks differ
    /// from round to round; the first way would do the same again, and only has the first one.
    pub(crate) fn late_run(
        &self,
        times: &Times,
        (task, sum): (u16, &Scheduled),
        known: &[Option<Latest>],
        (limits, round): (&Limits, u64),
    ) -> Option<Steps> {
        if limits.time.is_zero() {
            return None;
        }
        let (parts, over, begin) = (self.parts(times, sum), AtomicBool::new(false), Instant::now());
        let processors = thread::available_parallelism().map_or(1, NonZero::get);
        let walkers = u8::try_from(processors).unwrap_or(WALKERS).min(WALKERS);
        let walked = Limits { memory: limits.memory / PART, ..*limits };
        let walks = |walker: u8| {
            let random = Random(0x9e37_79b9_7f4a_7c15 + round * 8 + u64::from(walker));
            self.walked(times, task, (&parts, known), (&walked.share(begin, 0), random), &over)
        };
        let search = || {
            let others = walked.memory * usize::from(walkers - 1);
            let time = limits.time / SEARCHED;
            let limits = Limits { memory: limits.memory - others, time, ..*limits };
            self.with_cycles(times, task, known, |longest| {
                parts.iter().zip(1..).find_map(|(part, number)| {
                    let limits = limits.share(begin, parts.len() - number);
                    let limits = Limits { states: limits.states.min(ZONES), ..limits };
                    seek(&limits, &Potential::new(part, times, task, longest)?, &over)
                })
            })
        };
        thread::scope(|scope| {
            let walks = &walks;
            let others: Vec<_> =
                (1..walkers).map(|walker| scope.spawn(move || walks(walker))).collect();
            let found = (round == 0).then(search).flatten();
            over.fetch_or(found.is_some(), Ordering::Relaxed);
            let mut found = found.or_else(|| walks(0));
            for other in others {
                let run = other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                found = found.or(run);
            }
            found
        })
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
        // The last two have all services; the very last one has aborts and events, too.
        let with_all = parts.len().saturating_sub(2);
        if random.below(4) == 0 {
            return parts[with_all].clone();
        }
        let mut part = parts[random.below(with_all)].clone();
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
