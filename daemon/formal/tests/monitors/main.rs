//! Whether rules can be broken: each verdict for each kind that is decided.

#![allow(clippy::unwrap_used, clippy::panic)]

mod between;
#[path = "../conformance/body.rs"]
mod body;
#[path = "../conformance/components.rs"]
mod components;
mod dates;
mod edges;
#[path = "../conformance/play.rs"]
#[allow(dead_code, reason = "what is seen of the runs is looked at by others")]
mod play;
#[path = "../conformance/random.rs"]
mod random;
mod replayed;
mod runtime;
mod times;

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{Bounds, Fires, Limits, System, Times, Trace};
use genom_protocol::LoadRequest;
use genom_runtime::Plan;
use serde_json::{Value, json};

const ARM: &str = "component arm {
  ids { long x; };
  typedef long place;
  port out place pose;
  event emergency;
  task t { period 10 ms; codel<start> init(out x) yield ether wcet 1 ms; };
  task slow { period 10 ms; codel<start> long_one() yield pause::start wcet 12 ms; };
  function calibrate() { codel zero(); };
  function reset() { codel clear() wcet 2 ms; };
  activity goto() {
    task t;
    codel<start> plan(out x) yield pause::main wcet 2 ms;
    codel<main> move(inout x, out pose) yield pause::main, ether wcet 3 ms;
    codel<stop> halt() yield ether wcet 1 ms;
    after calibrate;
    interrupts goto;
  };
};";

/// The verdict on a rule: the word, what happens, and the run.
fn fires_in(text: &str, rule: Value) -> (String, Vec<String>) {
    fires_with(text, rule, |_| {})
}

/// The same with other times of codels than those that are declared, or 1 ms.
fn fires_with(text: &str, rule: Value, set: impl Fn(&mut Times)) -> (String, Vec<String>) {
    let (verdict, run) = dated_with(text, rule, set);
    (verdict, run.into_iter().map(|(_, line)| line).collect())
}

/// The same with the dates of the lines in nanoseconds, if they have some.
fn dated_with(
    text: &str,
    rule: Value,
    set: impl Fn(&mut Times),
) -> (String, Vec<(Option<u64>, String)>) {
    let analysis = read_text("arm.gen", text, &Options::default());
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    let request = json!({"library": "arm", "supervision": rule});
    let request: LoadRequest = serde_json::from_value(request).unwrap();
    let rules = genom_rules::rules(&request, plan.component()).unwrap();
    let mut times = Times::declared(plan.component());
    times.bound_others(1_000_000);
    set(&mut times);
    let limits = Limits { time: std::time::Duration::MAX, ..Limits::default() };
    let bounds = Bounds { instances: 1, kill: false, ..Bounds::default() };
    let fires = System::new(&plan, bounds).fires(&rules[0].rule, Ok(&times), &limits);
    let lines = |run: Trace| -> Vec<(Option<u64>, String)> {
        let told = |line: &genom_formal::Line| format!("{}: {}", line.who, line.what);
        run.lines().map(|(date, line)| (date, told(line))).collect()
    };
    match fires {
        Fires::Never => ("never".into(), Vec::new()),
        Fires::Can { what, run } => (format!("can: {what}"), lines(run)),
        Fires::Always { what, run } => (format!("always: {what}"), lines(run)),
        Fires::Undecided(why) => (format!("undecided: {why}"), Vec::new()),
    }
}

#[track_caller]
fn check(rule: Value, told: &str) -> Vec<String> {
    let (verdict, run) = fires_in(ARM, rule);
    assert_eq!(verdict, told, "{run:#?}");
    run
}

#[test]
fn an_order_that_the_description_ensures_is_proved_and_one_that_it_does_not_has_a_run() {
    // `after calibrate` refuses the request.
    check(json!({"service": "goto", "after": "calibrate"}), "never");
    check(json!({"codel": "plan", "after": "zero"}), "never");
    check(json!({"formula": "plan -> once end(calibrate)"}), "never");
    check(
        json!({"order": ["new: calibrate -> ready", "ready: calibrate -> ready",
        "ready: goto -> ready"]}),
        "never",
    );
    let run = check(json!({"service": "reset", "after": "calibrate"}), "can: reset started");
    assert_eq!(run.last().unwrap(), "client: requests reset");
    let run = check(json!({"service": "reset", "never_while": "goto"}), "can: reset started");
    assert_eq!(run.iter().filter(|line| line.contains("requests")).count(), 3, "{run:#?}");
    let run =
        check(json!({"codel": "clear", "never_while": "goto"}), "can: codel clear was called");
    assert!(run.contains(&"client: requests goto".to_owned()), "{run:#?}");
}

#[test]
fn an_activity_that_interrupts_itself_never_starts_while_it_runs() {
    check(json!({"formula": "start(goto) -> not previous run(goto)"}), "never");
    check(json!({"formula": "move -> run(goto)"}), "never");
    check(json!({"formula": "end(goto) -> once start(goto)"}), "never");
    // Its stop codel may be called before `move` was.
    check(json!({"formula": "halt -> once move"}), "can: codel halt was called");
}

#[test]
fn what_breaks_a_rule_each_time_is_told_as_a_wrong_rule() {
    let (verdict, _) = fires_in(ARM, json!({"formula": "move -> once clear and not once clear"}));
    assert_eq!(verdict, "can: codel move was called", "`clear` itself does not break it");
    check(json!({"formula": "move -> false"}), "always: codel move was called");
    check(json!({"formula": "not calibrate"}), "always: calibrate started");
    let codel = json!({"codel": "plan", "longest_ms": 1});
    check(codel, "can: codel plan may take 2.000 ms, and 1.000 ms are allowed");
}

#[test]
fn a_port_that_a_codel_may_write_is_written_or_not() {
    check(json!({"formula": "pose -> once move"}), "never");
    check(json!({"formula": "return(move) -> previous pose"}), "can: codel move returned");
}

#[test]
fn deadlines_of_codels_and_cycles_are_decided_by_times() {
    check(json!({"codel": "move", "longest_ms": 3}), "never");
    check(json!({"wcet": true}), "never");
    let run = check(
        json!({"codel": "move", "longest_ms": 2.5}),
        "can: codel move may take 3.000 ms, and 2.500 ms are allowed",
    );
    assert!(run.last().unwrap().contains("plan yields pause::main") || !run.is_empty());
    check(json!({"task": "t", "longest_ms": 9}), "never");
    check(json!({"task": "t", "missed": 1}), "never");
    let (verdict, run) = fires_in(ARM, json!({"task": "t", "longest_ms": 2}));
    assert!(verdict.starts_with("can: a cycle of task t may take "), "{verdict}");
    assert!(!run.is_empty());
    let (verdict, run) = fires_in(ARM, json!({"task": "slow", "missed": 1}));
    assert_eq!(verdict, "can: slow is still at work at its tick");
    assert!(!run.is_empty());
}

#[test]
fn steps_of_state_machines_are_found_where_they_are_taken() {
    check(json!({"activity": "goto", "from": "start", "to": "main"}), {
        "can: it goes from start to main"
    });
    let unused = ARM.replace("yield pause::main wcet 2 ms", "yield ether, pause::main wcet 2 ms");
    let (verdict, run) =
        fires_in(&unused, json!({"activity": "goto", "from": "main", "to": "ether"}));
    assert_eq!(verdict, "can: it goes from main to ether");
    assert!(run.last().unwrap().ends_with("move yields ether"), "{run:#?}");
}

#[test]
fn bounds_that_only_ask_for_more_leave_what_breaks_a_formula_and_those_for_less_what_never_does() {
    // The port is not written before the first call.
    let run = check(json!({"formula": "move -> once[0, 2s] pose"}), "can: codel move was called");
    assert!(run.contains(&"client: requests goto".to_owned()), "{run:#?}");
    check(json!({"formula": "move -> not historically[0, 2s] not pose"}), {
        "can: codel move was called"
    });
    // Nothing runs before.
    check(json!({"formula": "init -> historically[0, 2s] not move"}), "never");
    check(json!({"formula": "init -> not once[0, 2s] move"}), "never");
}

#[test]
fn formulas_with_bounds_are_decided_by_the_times_of_codels() {
    // `move` takes 3 ms at most, and writes the port when it returns.
    check(json!({"formula": "pose -> once[0, 3ms] move"}), "never");
    check(json!({"formula": "pose -> once[0, 2999us] move"}), "can: port pose was written");
    check(json!({"formula": "pose -> not once[3ms, inf] move"}), "can: port pose was written");
    check(json!({"formula": "pose -> not once[3001us, inf] plan"}), "can: port pose was written");
    // Once it was called, the activity pauses until the next tick.
    check(json!({"formula": "move -> not once[0, 5ms] plan"}), "never");
    check(json!({"formula": "move -> not once[0, 10ms] plan"}), "can: codel move was called");
    check(json!({"formula": "move -> once[5ms, inf] plan"}), "never");
    check(json!({"formula": "move -> once[10ms, inf] calibrate"}), "never");
    check(json!({"formula": "move -> once[10001us, inf] calibrate"}), "can: codel move was called");
    // Both bounds at once, and of parts in parts.
    check(json!({"formula": "once[0, 2s] pose -> once[0, 1s] move"}), "never");
    check(json!({"formula": "not once[0, 5ms] pose"}), "always: port pose was written");
    let since = "clear -> not previous (not clear since[0, 1ms] return(clear))";
    check(json!({"formula": since}), "can: codel clear was called");
}

#[test]
fn a_run_that_breaks_a_formula_with_bounds_is_told() {
    let run = check(json!({"formula": "pose -> once[0, 2ms] move"}), "can: port pose was written");
    assert!(run.contains(&"client: requests goto".to_owned()), "{run:#?}");
    assert!(run.last().unwrap().contains("move yields"), "{run:#?}");
}

#[test]
fn what_is_not_explored_is_said_to_be_undecided() {
    for (rule, why) in [
        (json!({"formula": "emergency -> once move"}), "event emergency was fired"),
        (json!({"formula": "move -> once t"}), "a cycle of task t began"),
    ] {
        let (verdict, _) = fires_in(ARM, rule.clone());
        assert!(verdict.starts_with("undecided: ") && verdict.contains(why), "{rule}: {verdict}");
    }
}
