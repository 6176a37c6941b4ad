//! Clocks, periods and other properties with implicit values (genom3.md 4.7).

use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _, TaskIx};

use super::{component, plain};

fn clock(tasks: &str) -> Option<Duration> {
    let specification = plain(&format!("component c {{ {tasks} }};"));
    component(&specification, "c").clock_rate
}

#[test]
fn the_clock_is_the_greatest_that_serves_all() {
    let ms = Duration::from_millis;
    assert_eq!(clock("task t;"), None);
    assert_eq!(clock("task t { period 5 ms; };"), Some(ms(5)));
    assert_eq!(clock("task t { period 1.5 s; };"), Some(ms(500)));
    assert_eq!(clock("task t { period 1.5ms; };"), Some(Duration::from_micros(500)));
    assert_eq!(
        clock("task t { period 6 ms; delay 4 ms; }; task u { period 10 ms; };"),
        Some(ms(2))
    );
    assert_eq!(clock("clock-rate 1 ms; task t { period 5 ms; };"), Some(ms(1)));
}

#[test]
fn a_constant_may_stand_before_the_unit() {
    let specification =
        plain("const long n = 3; component c { task t { period n * 2 ms; delay n us; }; };");
    let task = &component(&specification, "c").tasks[TaskIx::new(0)];
    assert_eq!(task.period, Some(Duration::from_millis(6)));
    assert_eq!(task.delay, Duration::from_micros(3));
}

#[test]
fn a_component_has_a_language_and_a_version() {
    let specification = plain("component c; component d { lang \"c++\"; version \"1\" \".2\"; };");
    let c = component(&specification, "c");
    assert_eq!((c.lang.as_str(), c.version.as_str()), ("c", "0"));
    let d = component(&specification, "d");
    assert_eq!((d.lang.as_str(), d.version.as_str()), ("c++", "1.2"));
}

#[test]
fn tasks_take_the_stack_and_scheduling_of_their_component() {
    let specification = plain(
        "component c { stack 2 M; scheduling real-time; task t; task u { stack 20k; priority 7; }; };",
    );
    let c = component(&specification, "c");
    assert_eq!(c.tasks[TaskIx::new(0)].stack, Some(2 << 20));
    assert_eq!(c.tasks[TaskIx::new(1)].stack, Some(20 << 10));
    assert_eq!(c.tasks[TaskIx::new(1)].priority, Some(7));
    assert!(c.tasks.iter().all(|task| task.real_time));
}

#[test]
fn codels_may_state_their_worst_time() {
    let specification = plain(
        "component c { task t { codel<start> x() yield ether wcet 2 ms; };
           function f() { codel y() wcet 10 us; }; };",
    );
    let c = component(&specification, "c");
    assert_eq!(c.codels[CodelIx::new(0)].wcet, Some(Duration::from_millis(2)));
    assert_eq!(c.codels[CodelIx::new(1)].wcet, Some(Duration::from_micros(10)));
}
