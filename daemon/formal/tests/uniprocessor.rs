//! Bounds of tasks on one processor are those of the crate `response-time-analysis`, whose analysis
//! of fixed priorities follows a proof that was checked by machine (Bozhko, Brandenburg: Abstract
//! Response-Time Analysis, ECRTS 2020).
//!
//! Both count whole units of time, and both say that a task ticks `ceil(d / period)` times in a
//! half-open interval of length `d`; here units are milliseconds there, and nanoseconds in what is
//! compared with it. There are four differences:
//!
//! * There, a response is the time since a cycle could begin. Here it is that since its tick, so the
//!   lateness of the task itself is added to what the crate says.
//! * There, a cycle may last beyond the next tick, and the ticks are served one after the other; so
//!   all cycles of a busy interval are looked at, and a response may be above the period. Here ticks
//!   that come while a task is at work are one, and a task that is at work at its next tick is late.
//!   Such a task has no bound here, and one that is not below the period, or none, there.
//! * A task of lower priority than one that is late has no bound here, but may have one there.
//! * Priorities: there, the caller says who interferes. All tasks here have different ones.
//!
//! So where a task and all of higher priority are in time, both bounds are the same number.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fmt::Write as _;
use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{
    Bounds, Cause, Machine, OnMachine, Placed, Processors, Scheduled, System, Threads,
};
use genom_runtime::Plan;
use response_time_analysis::arrival::Sporadic;
use response_time_analysis::demand::RBF;
use response_time_analysis::fixed_priority::fully_preemptive::dedicated_uniproc_rta;
use response_time_analysis::time::{Duration, Service};
use response_time_analysis::wcet::Scalar;

#[path = "conformance/random.rs"]
mod random;

use random::Random;

const MS: u64 = 1_000_000;

/// A busy interval that is longer than this many milliseconds has no end there. A task that is in
/// time has one shorter than its period, which is less.
const LIMIT: u64 = 200;

/// A task that shares no data with others. In milliseconds.
#[derive(Clone, Copy, Debug)]
struct Task {
    period: u64,
    work: u64,
    late: u64,
}

/// Tasks in the order of their priorities, the highest first, which is not always that of periods.
fn tasks(random: &mut Random, late: impl Fn(&mut Random) -> u64) -> Vec<Task> {
    let count = *random.one(&[2, 3, 4, 5, 6]);
    let number = |random: &mut Random, below: u64| {
        u64::try_from(random.below(usize::try_from(below).unwrap())).unwrap()
    };
    let one = |_| {
        let period = 5 + number(random, 60);
        let work = 1 + number(random, period * 3 / u64::try_from(2 * count).unwrap());
        Task { period, work, late: late(random) }
    };
    let mut tasks: Vec<Task> = (0..count).map(one).collect();
    if random.percent(70) {
        tasks.sort_by_key(|task| task.period);
    }
    tasks
}

fn system(tasks: &[Task], priority: usize) -> System {
    let mut text = String::from("component c {\n");
    for (at, Task { period, work, .. }) in tasks.iter().enumerate() {
        let priority = priority + at;
        writeln!(
            text,
            "task t{at} {{ period {period} ms; priority {priority}; scheduling real-time;
               codel<start> c{at}() yield pause::start wcet {work} ms; }};"
        )
        .unwrap();
    }
    text.push_str("};");
    let options = Options { standard_interface: false, ..Options::default() };
    let analysis = read_text("c.gen", &text, &options);
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).unwrap();
    System::new(&Arc::new(plan), Bounds::default())
}

/// What the crate says of the last of these tasks, from its tick: `None` if its cycle may not be
/// over before the next one.
fn peer(tasks: &[Task]) -> Option<u64> {
    let demand = |task: &Task| {
        let ticks = Sporadic::new(Duration::from(task.period), Duration::from(task.late));
        RBF::new(ticks, Scalar::new(Service::from(task.work)))
    };
    let (own, higher) = tasks.split_last().unwrap();
    let higher: Vec<_> = higher.iter().map(demand).collect();
    let found = dedicated_uniproc_rta(&demand(own), &higher, Duration::from(LIMIT)).ok()?;
    let response = u64::from(found) + own.late;
    (response < own.period).then_some(response)
}

/// How many tasks were in time, late, and below a late one.
#[derive(Debug, Default)]
struct Seen {
    fit: usize,
    late: usize,
    below: usize,
}

impl Seen {
    /// Compares what was found of tasks.
    fn compare(&mut self, tasks: &[Task], found: &[&Scheduled]) {
        assert_eq!(tasks.len(), found.len());
        let mut bounded = true;
        for (at, own) in found.iter().enumerate() {
            if !bounded {
                assert!(matches!(own.response, Err(Cause::Preempted(_))), "{tasks:?} {own:?}");
                self.below += 1;
                continue;
            }
            let expected = peer(&tasks[..=at]);
            let here = own.response.as_ref().ok().copied();
            assert_eq!(here, expected.map(|response| response * MS), "{tasks:?} {own:?}");
            if expected.is_some() {
                self.fit += 1
            } else {
                self.late += 1
            }
            bounded = expected.is_some();
        }
    }
}

#[test]
fn tasks_of_one_component_have_the_bounds_of_another_analysis() {
    let mut random = Random(1);
    let mut seen = Seen::default();
    for _ in 0..400 {
        // One lateness for all, and none in half of the cases.
        let late = if random.percent(50) { 0 } else { u64::try_from(random.below(6)).unwrap() };
        let tasks = tasks(&mut random, |_| late);
        let system = system(&tasks, 10);
        let found = system.schedule(&system.declared_times(), Processors::Shared(1), late * MS);
        seen.compare(&tasks, &found.tasks.iter().collect::<Vec<_>>());
    }
    assert!(seen.fit > 500 && seen.late > 100 && seen.below > 50, "{seen:?}");
}

#[test]
fn tasks_of_several_components_each_late_in_its_way_have_the_bounds_of_another_analysis() {
    let mut random = Random(2);
    let mut seen = Seen::default();
    for _ in 0..400 {
        let tasks = tasks(&mut random, |random| u64::try_from(random.below(6)).unwrap());
        let systems: Vec<System> =
            tasks.iter().enumerate().map(|(at, task)| system(&[*task], 10 + at)).collect();
        let components = systems.iter().zip(&tasks).enumerate().map(|(at, (system, task))| {
            let threads = vec![Threads { cpus: vec![0], late: task.late * MS }];
            Placed { name: format!("c{at}"), system, times: system.declared_times(), threads }
        });
        let found = Machine { processors: 1, components: components.collect() }.schedule();
        let found: Vec<&Scheduled> = found.iter().map(|OnMachine { task, .. }| task).collect();
        seen.compare(&tasks, &found);
    }
    assert!(seen.fit > 500 && seen.late > 100 && seen.below > 50, "{seen:?}");
}
