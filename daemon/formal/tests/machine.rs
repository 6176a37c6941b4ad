//! Bounds of tasks of several components on the processors of one machine.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{
    Bounds, Cause, Change, Machine, OnMachine, Placed, Processors, System, Threads,
};
use genom_runtime::Plan;

#[path = "conformance/random.rs"]
mod random;

const MS: u64 = 1_000_000;

const DUO: &str = "component duo { ids { long shared; };
  task fast { period 10 ms; priority 10; scheduling real-time;
    codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; priority 20; scheduling real-time;
    codel<start> sb(inout shared) yield work wcet 2 ms;
    codel<work> sw() yield pause::start wcet 5 ms; }; };";

fn system(text: &str) -> System {
    let analysis =
        read_text("c.gen", text, &Options { standard_interface: false, ..Options::default() });
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    let plan = Plan::new(&Arc::new(analysis.specification), 0).unwrap();
    System::new(&Arc::new(plan), Bounds::default())
}

fn placed<'a>(name: &str, system: &'a System, cpus: &[&[usize]]) -> Placed<'a> {
    let threads = cpus.iter().map(|cpus| Threads { cpus: cpus.to_vec(), late: 0 });
    let (name, times) = (name.to_owned(), system.declared_times());
    Placed { name, system, times, threads: threads.collect() }
}

/// One task of one codel.
fn task(name: &str, period: u64, work: u64, priority: u64) -> System {
    system(&format!(
        "component {name} {{ task t {{ period {period} ms; priority {priority};
           scheduling real-time; codel<start> c() yield pause::start wcet {work} ms; }}; }};"
    ))
}

fn responses(found: &[OnMachine]) -> Vec<Result<u64, Cause>> {
    found.iter().map(|one| one.task.response.clone()).collect()
}

#[test]
fn one_component_on_one_processor_has_the_bounds_that_it_has_alone() {
    let system = system(DUO);
    let alone = system.schedule(&system.declared_times(), Processors::Shared(1), 0);
    let machine = Machine { processors: 1, components: vec![placed("duo", &system, &[])] };
    let found = machine.schedule();
    let alone: Vec<_> = alone.tasks.iter().map(|task| task.response.clone()).collect();
    assert_eq!(responses(&found), alone);
    assert_eq!(alone, [Ok(5 * MS), Ok(17 * MS)]);
}

#[test]
fn a_task_is_preempted_by_tasks_of_other_components_on_its_processor_only() {
    let (duo, other) = (system(DUO), task("other", 20, 4, 5));
    let on = |cpu: usize| {
        let components =
            vec![placed("duo", &duo, &[&[0], &[0]]), placed("other", &other, &[&[cpu]])];
        responses(&Machine { processors: 2, components }.schedule())
    };
    // Elsewhere: as if it were not there.
    assert_eq!(on(1), [Ok(5 * MS), Ok(17 * MS), Ok(4 * MS)]);
    // 4 more for `fast`. For `slow` 7, three times the 5 of `fast` and two times 4.
    assert_eq!(on(0), [Ok(9 * MS), Ok(30 * MS), Ok(4 * MS)]);
}

#[test]
fn what_would_do_is_told_for_a_task_that_is_late() {
    let (one, two) = (task("one", 10, 6, 10), task("two", 20, 9, 20));
    let components = vec![placed("one", &one, &[&[0]]), placed("two", &two, &[&[0]])];
    let machine = Machine { processors: 2, components };
    assert_eq!(responses(&machine.schedule()), [Ok(6 * MS), Err(Cause::Late(20 * MS))]);
    let changes = machine.changes();
    let expected = |change: &Change| assert!(changes.contains(change), "{changes:#?}");
    expected(&Change::Processor { task: "one/t".into(), cpu: 1 });
    expected(&Change::Processor { task: "two/t".into(), cpu: 1 });
    // 20 ms less two times 6 leave 8, and a cycle that ends at its next tick is late.
    let (codel, task) = ("two/c".to_owned(), "two/t".to_owned());
    expected(&Change::Time { codel, below: 8 * MS, task });
    // Priorities are in the order of periods already.
    assert!(!changes.iter().any(|change| matches!(change, Change::Order(_))), "{changes:#?}");
    let apart = vec![placed("one", &one, &[&[0]]), placed("two", &two, &[&[1]])];
    assert!(Machine { processors: 2, components: apart }.changes().is_empty());
}

#[test]
fn the_order_of_periods_is_told_if_it_is_enough() {
    let (one, two) = (task("one", 10, 4, 20), task("two", 40, 10, 10));
    let components = vec![placed("one", &one, &[]), placed("two", &two, &[])];
    let changes = Machine { processors: 1, components }.changes();
    let order = vec!["one/t".to_owned(), "two/t".to_owned()];
    assert!(changes.contains(&Change::Order(order)), "{changes:#?}");
}

#[test]
fn a_task_without_real_time_priority_preempts_none_and_has_no_bound() {
    let text = DUO.replace("scheduling real-time;", "");
    let (any, other) = (system(&text), task("other", 20, 4, 200));
    let components = vec![placed("any", &any, &[]), placed("other", &other, &[])];
    let found = responses(&Machine { processors: 1, components }.schedule());
    assert!(matches!(&found[0], Err(Cause::NotRealTime(name)) if name == "any/fast"), "{found:?}");
    assert_eq!(found[2], Ok(4 * MS));
}

/// What is simulated of a task, in milliseconds.
struct Job {
    period: u64,
    work: u64,
    cpus: Vec<usize>,
    left: u64,
    released: u64,
}

/// The longest responses if all tick at once, millisecond by millisecond: the task of the highest
/// priority first, on the first processor that is free. `None` for one that misses a tick.
fn simulated(jobs: &mut [Job], processors: usize, until: u64) -> Vec<Option<u64>> {
    let mut longest = vec![Some(0); jobs.len()];
    for now in 0..until {
        let mut free = vec![true; processors];
        for (at, job) in jobs.iter_mut().enumerate() {
            if now.is_multiple_of(job.period) {
                if job.left > 0 {
                    longest[at] = None;
                }
                (job.left, job.released) = (job.work, now);
            }
            let cpu = job.cpus.iter().copied().find(|cpu| free[*cpu]);
            if let (true, Some(cpu)) = (job.left > 0, cpu) {
                free[cpu] = false;
                job.left -= 1;
                if job.left == 0 {
                    let response = now + 1 - job.released;
                    longest[at] = longest[at].map(|longest: u64| longest.max(response));
                }
            }
        }
    }
    longest
}

#[test]
fn bounds_are_never_below_what_is_simulated_wherever_tasks_may_run() {
    let mut random = random::Random(11);
    let (mut compared, mut equal) = (0, 0);
    for _ in 0..300 {
        let processors = 1 + random.below(3);
        let count = 2 + random.below(4);
        let mut jobs = Vec::new();
        for _ in 0..count {
            let period = *random.one(&[6, 8, 12, 24]);
            let work = 1 + u64::try_from(random.below(4)).unwrap();
            let mut cpus: Vec<usize> = (0..processors).filter(|_| random.percent(60)).collect();
            if cpus.is_empty() {
                cpus.push(random.below(processors));
            }
            jobs.push(Job { period, work, cpus, left: 0, released: 0 });
        }
        let systems: Vec<System> = jobs
            .iter()
            .zip(1..)
            .map(|(job, priority)| task("c", job.period, job.work, priority))
            .collect();
        let components = systems
            .iter()
            .zip(&jobs)
            .enumerate()
            .map(|(at, (system, job))| placed(&format!("c{at}"), system, &[&job.cpus]));
        let machine = Machine { processors, components: components.collect() };
        let found = responses(&machine.schedule());
        let seen = simulated(&mut jobs, processors, 48);
        for (bound, seen) in found.iter().zip(&seen) {
            let Ok(bound) = bound else { continue };
            compared += 1;
            let seen = seen.map(|ms| ms * MS);
            assert!(seen.is_some_and(|seen| seen <= *bound), "{bound} {seen:?}");
            equal += usize::from(seen == Some(*bound));
        }
    }
    assert!(compared > 300 && equal > 100, "{compared} {equal}");
}
