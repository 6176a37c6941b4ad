//! How long a cycle may still get never grows while its task is at work: bounds are no lower than any
//! run, and what has no way left to be late is not looked at first.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_runtime::Plan;

use super::clocks::{Clock, clocks, guarded, initial, stepped};
use super::explore::works;
use super::potential::Potential;
use crate::action::{Action, Answer};
use crate::bounds::Bounds;
use crate::state::At;
use crate::system::System;
use genom_timing::Random;

#[path = "../sizes/component.rs"]
mod component;
#[path = "../conformance/random.rs"]
mod random;

/// An activity that comes to `stop` by itself.
const STOPS: &str = "component stops { task t { period 10 ms; };
  activity a() { task t;
    codel<start> a_start() yield main wcet 1 ms;
    codel<main> a_main() yield pause::main, stop wcet 1 ms;
    codel<stop> a_stop() yield ether wcet 3 ms; };
};";

/// Takes a random run and looks at what cycles of this task may take, before and after each step from
/// the tick on, and when the step is taken at the latest; returns how many steps these are.
fn never_grows(text: &str, task: u16, seed: u64) -> usize {
    let analysis = read_text("random.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    let system = System::new(&plan, Bounds { kill: false, fire: false, ..Bounds::default() });
    let mut times = system.declared_times();
    times.bound_others(1_000_000);
    let times = times.longest_of(&system, task);
    let any = |_: &[_]| u64::MAX;
    let Some(potential) = Potential::new(&system, &times, task, &any) else { return 0 };
    let mut state = system.initial(false);
    let mut zone = initial(&system, &times, &state).unwrap();
    let (mut before, mut looked, mut random) = (u64::MAX, 0, Random(seed));
    for _ in 0..4_000 {
        let known = clocks(&system, &times, &state);
        let mut all = Vec::new();
        // An exception of a permanent activity would end the component.
        let fails = |action: &Action| matches!(action, Action::Return(_, Answer::Fail));
        for action in system.timed(&state).into_iter().filter(|action| !fails(action)) {
            let Some(zone) = guarded(&system, &times, (&state, &known), &zone, action) else {
                continue;
            };
            let next = system.after(&state, action, &mut Vec::new());
            let after = clocks(&system, &times, &next);
            let tick = known.iter().position(|clock| *clock == Clock::Tick(task)).unwrap();
            let date = u64::try_from(zone.most(tick + 1).unwrap()).unwrap();
            let zone = stepped(&system, &times, (&known, &zone), action, (&next, &after));
            all.extend(zone.map(|zone| (action, date, next, after, zone)));
        }
        let at = random.below(all.len());
        let Some((action, date, next, after, reached)) = all.into_iter().nth(at) else { break };
        let most = potential.of(&next, (&after, &reached));
        let begins = matches!(next.tasks[usize::from(task)].at, At::Begin { tick: true });
        // What has no way left to be late is not looked at more nearly.
        let grows =
            !begins && works(&next, usize::from(task)) && most > before && most >= potential.period;
        let is_fine = before == u64::MAX || date <= before && !grows;
        assert!(is_fine, "{before} ns, then {most}, {action:?} at {date}:\n{state:#?}\n{text}");
        looked += usize::from(before < u64::MAX);
        // One that begins after a late cycle has an older tick, and is late whatever it takes.
        let tick = after.iter().position(|clock| *clock == Clock::Tick(task)).unwrap();
        let is_late = begins && reached.most(tick + 1) != Some(0);
        let is_known = works(&next, usize::from(task)) && !is_late;
        before = if is_known { most } else { u64::MAX };
        (state, zone) = (next, reached);
    }
    looked
}

#[test]
fn an_activity_that_comes_to_stop_by_itself_is_not_asked_to_stop_again() {
    assert!(never_grows(STOPS, 0, 1) > 100);
}

#[test]
fn how_long_a_cycle_may_get_never_grows_while_its_task_is_at_work() {
    let mut looked = 0;
    for seed in 0..20 {
        let size = component::Size { tasks: 3, activities: 10, functions: 4 };
        let text = component::component(&mut random::Random(seed), size);
        looked += (0..3).map(|task| never_grows(&text, task, seed + 1)).sum::<usize>();
    }
    assert!(looked > 10_000, "{looked} steps");
}
