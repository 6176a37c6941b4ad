//! Random walks find a task that is late, and what they find is a run.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use genom_description::{Options, read_text};
use genom_runtime::Plan;
use genom_timing::{Limits, Random};

use super::explore::Timed;
use super::potential::Potential;
use super::seek::{Steps, seek};
use super::walks::walks;
use crate::action::Action;
use crate::bounds::Bounds;
use crate::system::System;

/// Two tasks that share data: the first one waits for what the second one executes for so long.
fn duo(wcet: &str) -> System {
    let text = format!(
        "component duo {{ ids {{ long shared; }};
           task fast {{ period 10 ms; codel<start> fa(inout shared) yield pause::start wcet 3 ms; }};
           task slow {{ period 40 ms; codel<start> sb(inout shared) yield work wcet {wcet};
                                      codel<work> sw() yield pause::start wcet 20 ms; }}; }};"
    );
    system(&text)
}

fn system(text: &str) -> System {
    let analysis = read_text("walks.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    System::new(&plan, Bounds { kill: false, ..Bounds::default() })
}

/// What both ways of looking for a run of the first task find.
fn found(system: &System, over: bool, ms: u64) -> [Option<Steps>; 2] {
    let times = system.declared_times();
    let any = |_: &[_]| u64::MAX;
    let potential = Potential::new(system, &times, 0, &any).unwrap();
    let limits = Limits { time: Duration::from_millis(ms), ..Limits::default() };
    let over = AtomicBool::new(over);
    [walks(&limits, &potential, &mut Random(1), &over).ok(), seek(&limits, &potential, &over)]
}

#[test]
fn a_task_that_is_late_is_found_by_a_run_that_is_one() {
    let system = duo("8 ms");
    for run in found(&system, false, 60_000) {
        is_one(&system, &run.unwrap());
    }
}

/// Each step is possible where it is taken, and the last one is a tick that is late.
fn is_one(system: &System, run: &Steps) {
    let mut now = system.initial(false);
    for (state, action) in run {
        assert_eq!(*state, now);
        assert!(system.timed(state).contains(action), "{action:?}");
        now = system.after(state, *action, &mut Vec::new());
    }
    let (last, tick) = run.last().unwrap();
    assert_eq!(Timed::is_late(last, *tick), Some(0));
}

#[test]
fn none_is_found_of_a_task_that_is_in_time_or_once_the_search_is_over() {
    assert_eq!(found(&duo("8 ms"), true, 60_000), [None, None]);
    assert_eq!(found(&duo("6 ms"), false, 300), [None, None]);
}

#[test]
fn walks_ask_for_activities_in_the_order_in_which_all_of_them_are_there() {
    // Each one interrupts the next one, so that all five begin at one tick if they were asked for from the
    // first one to the last one; four of them are in time.
    let activity = |at: usize| {
        let next = if at < 4 { format!(", a{}", at + 1) } else { String::new() };
        format!(
            "activity a{at}() {{ task t; interrupts a{at}{next}; validate a{at}_check() wcet 1 ms;
               codel<start> a{at}_start() yield ether wcet 2 ms; }};"
        )
    };
    let all: String = (0..5).map(activity).collect();
    let system = system(&format!("component five {{ task t {{ period 10 ms; }}; {all} }};"));
    let times = system.declared_times();
    let any = |_: &[_]| u64::MAX;
    let potential = Potential::new(&system, &times, 0, &any).unwrap();
    for seed in 1..60 {
        let over = AtomicBool::new(false);
        let run = walks(&Limits::default(), &potential, &mut Random(seed), &over).unwrap();
        is_one(&system, &run);
        let asks = |action: &Action| matches!(action, Action::Request(_));
        assert!(run.iter().filter(|(_, action)| asks(action)).count() >= 5);
    }
}
