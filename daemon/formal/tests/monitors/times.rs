//! Rules about times that something takes, and between what happens.

use genom_description::{Options, read_text};
use genom_formal::{Bounds, Duration, Fires, Longest, System, Times};
use genom_runtime::{Plan, Rule};
use serde_json::json;

use super::{ARM, Arc, check, components, fires_in, fires_with, random};

const MS: u64 = 1_000_000;

/// A task whose cycles are long each fourth time, and one activity that ends by itself.
pub(super) const PACED: &str = "component paced {
  typedef long number;
  port out number value;
  task five { period 5 ms; codel<start> tick(out value) yield pause::start wcet 1 ms; };
  task ten { period 10 ms; };
  task four { period 10 ms;
    codel<start> big() yield pause::a wcet 12 ms;
    codel<a> small_a() yield pause::b wcet 1 ms;
    codel<b> small_b() yield pause::c wcet 1 ms;
    codel<c> small_c() yield pause::start wcet 1 ms; };
  activity once() { task ten; codel<start> go() yield ether wcet 4 ms; };
  activity loops() { task ten; codel<start> turn() yield pause::start wcet 1 ms;
    codel<stop> halt() yield ether wcet 3 ms; interrupts once; };
};";

/// Sets the least time of a codel, and the longest one.
pub(super) fn takes(text: &str, codel: &str, least: u64, most: Option<u64>) -> impl Fn(&mut Times) {
    let analysis = read_text("c.gen", text, &Options::default());
    let plan = Plan::new(&Arc::new(analysis.specification), 0).unwrap();
    let time = Duration { least: least * MS, most: most.map(|most| most * MS) };
    move |times: &mut Times| assert!(times.set(plan.component(), codel, time), "{codel}")
}

#[track_caller]
fn paced(rule: serde_json::Value, told: &str) -> Vec<String> {
    let (verdict, run) = fires_in(PACED, rule);
    assert_eq!(verdict, told, "{run:#?}");
    run
}

#[test]
fn an_activity_takes_from_its_acceptance_to_its_answer() {
    // Accepted just after a tick, it waits for the next one, and then for `halt` of the other one.
    paced(json!({"activity": "once", "longest_ms": 17}), "never");
    let run = paced(
        json!({"activity": "once", "longest_ms": 16.9}),
        "can: activity once may take longer than 16.900 ms",
    );
    assert!(run.contains(&"once: is accepted".to_owned()), "{run:#?}");
    // Only an abort or a shutdown ends this one.
    paced(
        json!({"activity": "loops", "longest_ms": 100}),
        "can: activity loops may take longer than 100.000 ms",
    );
    let rule = json!({"activity": "once", "longest_ms": 2});
    let (verdict, _) = fires_with(PACED, rule.clone(), takes(PACED, "go", 3, Some(4)));
    assert_eq!(verdict, "always: activity once may take longer than 2.000 ms");
    let (verdict, _) = fires_with(PACED, rule, takes(PACED, "go", 2, Some(4)));
    assert_eq!(verdict, "can: activity once may take longer than 2.000 ms");
}

#[test]
fn an_activity_takes_from_when_it_was_asked_to_stop_to_its_end() {
    // Asked in the pass of a tick, `halt` comes with the next one.
    check(json!({"activity": "goto", "longest_stop_ms": 11}), "never");
    let run = check(
        json!({"activity": "goto", "longest_stop_ms": 10.9}),
        "can: activity goto may take longer than 10.900 ms to its end after it was asked to stop",
    );
    assert!(run.iter().any(|line| line.contains("aborts goto")), "{run:#?}");
    paced(json!({"activity": "loops", "longest_stop_ms": 17}), "never");
    let rule = json!({"activity": "loops", "longest_stop_ms": 2});
    let (verdict, run) = fires_with(PACED, rule.clone(), takes(PACED, "halt", 3, Some(3)));
    assert_eq!(
        verdict,
        "always: activity loops may take longer than 2.000 ms to its end after it was asked to stop"
    );
    assert!(!run.is_empty());
    let (verdict, _) = fires_with(PACED, rule, takes(PACED, "halt", 2, Some(3)));
    assert!(verdict.starts_with("can: "), "{verdict}");
}

#[test]
fn the_longest_stop_that_is_told_is_the_least_limit_that_nothing_breaks() {
    let (mut compared, mut unbounded) = (0, 0);
    for seed in 0..40 {
        let text = components::component(&mut random::Random(seed));
        let bounds = Bounds { instances: 1, kill: false, fire: false, ..Bounds::default() };
        let analysis = read_text("c.gen", &text, &Options::default());
        let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
        let system = System::new(&plan, bounds);
        let mut times = Times::declared(plan.component());
        times.bound_others(MS);
        let limits = genom_formal::Limits {
            time: std::time::Duration::MAX,
            states: 1_000,
            ..genom_formal::Limits::default()
        };
        for response in system.respond(&times, &limits) {
            if response.begins == Longest::Never {
                continue;
            }
            let services = &plan.component().services;
            let service = services.find(|one| one.name == response.service).unwrap();
            let fires = |ns: u64| {
                let rule = Rule::Stop { service, longest: std::time::Duration::from_nanos(ns) };
                system.fires(&rule, Ok(&times), &limits)
            };
            match response.ends {
                Longest::Most(most) => {
                    // Both may come to the limit on states, and the one here has a greater one.
                    if matches!(fires(most), Fires::Undecided(_)) {
                        continue;
                    }
                    assert_eq!(fires(most), Fires::Never, "seed {seed}: {most}\n{text}");
                    let below = fires(most - 1);
                    let breaks = matches!(below, Fires::Can { .. } | Fires::Always { .. });
                    assert!(breaks, "seed {seed}: {most}, {below:?}\n{text}");
                    compared += 1;
                }
                Longest::Unbounded(_) | Longest::More(_) => {
                    let far = fires(100 * MS);
                    assert_ne!(far, Fires::Never, "seed {seed}, {response:?}\n{text}");
                    unbounded += 1;
                }
                Longest::Never | Longest::Undecided(_) => {}
            }
        }
    }
    assert!(compared > 5 && unbounded > 5, "{compared} {unbounded}");
}

#[test]
fn a_codel_is_called_as_often_as_its_task_ticks() {
    paced(json!({"codel": "tick", "every_ms": [5, 5.1]}), "never");
    paced(
        json!({"codel": "tick", "every_ms": [6, 8]}),
        "always: codel tick may be called again within less than 6.000 ms",
    );
    paced(
        json!({"codel": "tick", "every_ms": [1, 4]}),
        "always: codel tick may not be called for longer than 4.000 ms",
    );
    let run = paced(
        json!({"codel": "big", "every_ms": [41, 100]}),
        "always: codel big may be called again within less than 41.000 ms",
    );
    assert!(run.iter().any(|line| line.contains("big yields")), "{run:#?}");
}

#[test]
fn a_codel_of_an_activity_is_waited_for_while_that_runs() {
    check(json!({"codel": "move", "every_ms": [8, 12]}), "never");
    // It may have been called 10 ms before `halt`, which takes 1 ms.
    check(
        json!({"codel": "move", "every_ms": [10, 10.5]}),
        "can: codel move may not be called for longer than 10.500 ms",
    );
    check(
        json!({"codel": "move", "every_ms": [10.5, 20]}),
        "always: codel move may be called again within less than 10.500 ms",
    );
    check(
        json!({"codel": "init", "every_ms": [1, 20], "while": "goto"}),
        "can: codel init may not be called for longer than 20.000 ms",
    );
    // `plan` is called once, when the activity starts.
    check(
        json!({"codel": "plan", "every_ms": [0, 30]}),
        "can: codel plan may not be called for longer than 30.000 ms",
    );
}

#[test]
fn a_port_that_a_codel_may_write_beats_or_not() {
    // It is written when the codel returns, which takes up to 1 ms, twice in a row or not at all.
    paced(
        json!({"port": "value", "every_ms": [0, 20]}),
        "can: port value may not be written for longer than 20.000 ms",
    );
    let rule = json!({"port": "value", "every_ms": [5, 1e9]});
    let (verdict, _) = fires_in(PACED, rule);
    assert!(verdict.starts_with("can: "), "{verdict}");
}

#[test]
fn ticks_are_missed_within_a_window() {
    // Each fourth cycle may miss one.
    let run = paced(json!({"task": "four", "missed": 1}), "can: four is still at work at its tick");
    assert_eq!(run.last().unwrap(), "four: tick");
    paced(json!({"task": "five", "missed": 1}), "never");
    paced(json!({"task": "four", "missed": 2, "within_ms": 30}), "never");
    paced(
        json!({"task": "four", "missed": 2, "within_ms": 40}),
        "can: four may miss 2 ticks within 40.000 ms",
    );
    let (verdict, _) = fires_in(PACED, json!({"task": "four", "missed": 2, "within_ms": 39}));
    assert!(verdict.starts_with("undecided: so many can be missed"), "{verdict}");
    paced(json!({"task": "four", "missed": 3, "within_ms": 70}), "never");
    // Two ticks in one cycle.
    let rule = json!({"task": "four", "missed": 2, "within_ms": 1});
    let (verdict, _) = fires_with(PACED, rule, takes(PACED, "big", 0, Some(21)));
    assert_eq!(verdict, "can: four may miss 2 ticks within 1.000 ms");
}

#[test]
fn a_cycle_that_always_takes_longer_has_a_wrong_limit() {
    check(json!({"task": "slow", "longest_ms": 12}), "never");
    let rule = json!({"task": "slow", "longest_ms": 11});
    let (verdict, _) = fires_in(ARM, rule.clone());
    assert_eq!(verdict, "can: a cycle of task slow may take longer than 11.000 ms");
    let (verdict, run) = fires_with(ARM, rule, takes(ARM, "long_one", 12, Some(12)));
    assert_eq!(verdict, "always: a cycle of task slow may take longer than 11.000 ms");
    assert!(!run.is_empty());
}

#[test]
fn a_codel_counts_as_stuck_beyond_its_wcet_and_what_the_runtime_waits() {
    check(json!({"stuck": true}), "never");
    // Of a request 5 s, of a task with a period of 10 ms one second.
    for (codel, least, most, told) in [
        ("zero", 0, 5_000, "never"),
        ("zero", 0, 6_000, "can: codel zero may take 6000.000 ms, and 5000.000 ms are allowed"),
        (
            "zero",
            5_500,
            6_000,
            "always: codel zero may take 6000.000 ms, and 5000.000 ms are allowed",
        ),
        ("halt", 0, 1_001, "can: codel halt may take 1001.000 ms, and 1000.000 ms are allowed"),
    ] {
        let rule = json!({"stuck": true, "codel": codel});
        let (verdict, _) = fires_with(ARM, rule, takes(ARM, codel, least, Some(most)));
        assert_eq!(verdict, told);
    }
    let rule = json!({"stuck": true, "codel": "zero"});
    let (verdict, _) = fires_with(ARM, rule, takes(ARM, "zero", 0, None));
    assert_eq!(verdict, "undecided: codel zero has no wcet: give --wcet");
}
