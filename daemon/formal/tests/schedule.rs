//! Bounds of response times: safe, and for small components the longest times that there are.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{
    Bounds, Cause, Duration, Limits, Processors, Schedule, Scheduled, System, Times,
};
use genom_runtime::Plan;

#[path = "conformance/components.rs"]
mod components;
#[path = "conformance/random.rs"]
mod random;

const MS: u64 = 1_000_000;

const DUO: &str = "component duo { ids { long shared; };
  task fast { period 10 ms; priority 10; scheduling real-time;
    codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; priority 20; scheduling real-time;
    codel<start> sb(inout shared) yield work wcet 8 ms;
    codel<work> sw() yield pause::start wcet 20 ms; }; };";

fn system(text: &str, bounds: Bounds) -> System {
    let analysis =
        read_text("duo.gen", text, &Options { standard_interface: false, ..Options::default() });
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    System::new(&Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap()), bounds)
}

fn times(system: &System, given: &[(&str, u64)]) -> Times {
    let mut times = system.declared_times();
    for (codel, most) in given {
        let duration = Duration { least: 0, most: Some(most * MS) };
        assert!(times.set(system.plan().component(), codel, duration), "{codel}");
    }
    times
}

fn schedule(text: &str, given: &[(&str, u64)], processors: Processors) -> Schedule {
    let system = system(text, Bounds::default());
    system.schedule(&times(&system, given), processors, 0)
}

fn one<'a>(schedule: &'a Schedule, name: &str) -> &'a Scheduled {
    schedule.tasks.iter().find(|task| task.name == name).unwrap()
}

#[test]
fn a_task_waits_for_each_other_context_once() {
    // As the zones say (times.rs): 9 ms and 29 ms, and 10 ms are an overrun.
    let found = schedule(DUO, &[("sb", 6)], Processors::Own);
    assert_eq!(one(&found, "fast").response, Ok(9 * MS));
    assert_eq!(one(&found, "slow").response, Ok(29 * MS));
    let found = schedule(DUO, &[("sb", 7)], Processors::Own);
    assert_eq!(one(&found, "fast").response, Err(Cause::Late(10 * MS)));
}

#[test]
fn what_would_have_to_be_shorter_is_told() {
    let found = schedule(DUO, &[], Processors::Own);
    let needed = [("fa".to_owned(), 2 * MS), ("sb".to_owned(), 7 * MS)];
    assert_eq!(one(&found, "fast").needed, needed);
}

#[test]
fn on_one_processor_a_task_waits_for_lower_ones_and_is_preempted_by_higher_ones() {
    let found = schedule(DUO, &[("sb", 2), ("sw", 5)], Processors::Shared(1));
    // 3, and 2 of `sb`, which has its priority meanwhile.
    assert_eq!(one(&found, "fast").response, Ok(5 * MS));
    // 7 of its own, and 5 for each of two cycles of `fast`, which may wait for it each time.
    assert_eq!(one(&found, "slow").response, Ok(17 * MS));
}

#[test]
fn threads_that_are_not_real_time_have_no_bound_on_shared_processors() {
    let text = DUO.replace("scheduling real-time;", "");
    let found = schedule(&text, &[], Processors::Shared(2));
    for task in &found.tasks {
        assert!(matches!(task.response, Err(Cause::NotRealTime(_))), "{task:?}");
    }
}

#[test]
fn of_activities_that_interrupt_each_other_one_counts() {
    let text = |interrupts: &str| {
        format!(
            "component c {{ task t {{ period 10 ms; }};
               activity a() {{ task t; codel<start> a0() yield pause::start wcet 2 ms;
                 {interrupts} }};
               activity b() {{ task t; codel<start> b0() yield pause::start wcet 1 ms;
                 {interrupts} }}; }};"
        )
    };
    // Two of each by default.
    assert_eq!(one(&schedule(&text(""), &[], Processors::Own), "t").response, Ok(6 * MS));
    let found = schedule(&text("interrupts a, b;"), &[], Processors::Own);
    assert_eq!(one(&found, "t").response, Ok(2 * MS));
}

#[test]
fn a_stop_comes_after_what_does_not_end_the_activity() {
    let text = |last: &str| {
        format!(
            "component c {{ task t {{ period 10 ms; }};
               activity a() {{ task t; codel<start> a0() yield main wcet 1 ms;
                 codel<main> a1() yield {last} wcet 2 ms;
                 codel<stop> a2() yield ether wcet 3 ms; interrupts a; }}; }};"
        )
    };
    let response =
        |last: &str| one(&schedule(&text(last), &[], Processors::Own), "t").response.clone();
    assert_eq!(response("pause::start"), Ok(6 * MS));
    // `a1` ends it: what comes after `a0` is either `a1` or `a2`.
    assert_eq!(response("ether"), Ok(4 * MS));
}

#[test]
fn a_task_waits_for_the_first_cycle_of_another_one_if_that_is_not_over_by_the_first_tick() {
    // `fast` ticks at 1 ms and then waits for `sb` until 3.6 ms.
    let text = "component c { ids { long m; };
      task fast { period 2 ms; delay 1 ms; codel<start> fa(inout m) yield pause::start wcet 500 us; };
      task slow { period 10 ms; codel<start> sa() yield next wcet 100 us;
        codel<next> sb(inout m) yield pause::main wcet 3 ms;
        codel<main> sc(inout m) yield pause::main wcet 100 us; }; };";
    let system = system(text, Bounds { kill: false, ..small() });
    let limits = Limits { time: std::time::Duration::MAX, ..Limits::default() };
    let zones = system.check_times(&system.declared_times(), &limits);
    assert!(zones.tasks[0].is_late());
    let found = schedule(text, &[], Processors::Own);
    assert!(one(&found, "fast").response.is_err(), "{found:?}");
}

#[test]
fn a_node_that_takes_no_time_may_be_arrived_at_when_another_task_ticks() {
    // `fb` arrives 2 ms after its tick, when `sa` begins. First cycles are over long before.
    let text = "component c { ids { long m; };
      task fast { period 16 ms; delay 6 ms; codel<start> f0() yield pause::main wcet 1 us;
        codel<main> fa() yield next wcet 2 ms;
        codel<next> fb(inout m) yield pause::main wcet 1 ms; };
      task slow { period 16 ms; delay 8 ms; codel<start> s0() yield pause::main wcet 1 us;
        codel<main> sa(inout m) yield pause::main wcet 3 ms; }; };";
    let system = system(text, Bounds { kill: false, ..small() });
    let times = times(&system, &[("fb", 0)]);
    let limits = Limits { time: std::time::Duration::MAX, ..Limits::default() };
    let zones = system.check_times(&times, &limits);
    assert_eq!(zones.tasks[0].response, Some(5 * MS));
    assert_eq!(one(&system.schedule(&times, Processors::Own, 0), "fast").response, Ok(5 * MS));
}

#[test]
fn bounds_are_never_below_what_zones_find() {
    let (mut compared, mut equal) = (0, 0);
    for seed in 0..200 {
        let mut random = random::Random(seed);
        let text = components::component(&mut random);
        let bounds = Bounds { fire: false, kill: false, abort: random.percent(50), ..small() };
        let system = system(&text, bounds);
        let mut times = system.declared_times();
        let names: Vec<String> =
            system.plan().component().codels.iter().map(|codel| codel.name.clone()).collect();
        for name in names {
            let most = u64::try_from(random.below(4)).unwrap() * MS / 4;
            times.set(system.plan().component(), &name, Duration { least: 0, most: Some(most) });
        }
        let limits = Limits { states: 3000, time: std::time::Duration::MAX, ..Limits::default() };
        let zones = system.check_times(&times, &limits);
        let found = system.schedule(&times, Processors::Own, 0);
        if zones.limit().is_some() {
            continue;
        }
        for (exact, bound) in zones.tasks.iter().zip(&found.tasks) {
            let most = match &bound.response {
                Ok(most) => *most,
                // No promise is made.
                Err(_) => continue,
            };
            compared += 1;
            assert!(exact.overrun.is_empty(), "seed {seed}, {}: {most}\n{text}", exact.name);
            let exact = exact.response.unwrap_or(0);
            assert!(exact <= most, "seed {seed}, {}: {exact} > {most}\n{text}", bound.name);
            equal += usize::from(exact == most);
        }
    }
    assert!(compared > 30 && equal > 10, "{compared} {equal}");
}

fn small() -> Bounds {
    Bounds { instances: 1, requests: 1, ..Bounds::default() }
}
