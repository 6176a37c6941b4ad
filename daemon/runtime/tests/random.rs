//! For any results of codels and any requests: each request is answered once, and everything ends.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use genom_runtime::{Clock, Instance, Options, Plan, Progress, VirtualClock};
use proptest::prelude::*;
use support::closures::Nobody;
use support::scripted::{Answer, Script, Scripted, Shared};

const GEN: &str = "component demo {
  ids { long a; };
  event alarm;
  exception E { long code; };
  task p { period 5 ms; codel<start> p1() yield ether; codel<stop> p2() yield ether; };
  task q { };
  attribute set(in a);
  function f() { codel f1(); codel f2(); interrupts one; throw E; };
  activity one() {
    task p;
    validate check();
    codel<start> a1() yield main, pause::main, ether, sleep, stop;
    codel<main> a2() yield main, pause::main, ether, start;
    codel<alarm> a3() yield ether, main, sleep;
    codel<stop> a4() yield ether, pause::stop;
    interrupts one;
    throw E;
  };
  activity two() {
    task q;
    codel<start> b1() yield main, pause::main, ether;
    codel<main> b2() yield pause::main, ether, start;
    interrupts one, two;
    after set;
  };
  activity three() { task q; codel<start> c1() yield pause::start, ether; codel<stop> c2() yield ether; };
};";

const CODELS: [&str; 9] = ["f1", "f2", "check", "a1", "a2", "a3", "b1", "b2", "c1"];
const EVENTS: [&str; 12] = [
    "ok",
    "ether",
    "main",
    "pause::main",
    "sleep",
    "start",
    "stop",
    "pause::stop",
    "E",
    "::x::y",
    "crash",
    "pause::start",
];
const SERVICES: [&str; 6] = ["set", "f", "one", "two", "three", "abort_activity"];

#[derive(Clone, Debug)]
enum Step {
    Request(usize),
    Abort(u32),
    Fire,
    Advance(u64),
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => (0..SERVICES.len()).prop_map(Step::Request),
        1 => (1u32..12).prop_map(Step::Abort),
        1 => Just(Step::Fire),
        4 => (0u64..12).prop_map(Step::Advance),
    ]
}

/// Plays the steps and shuts down; returns the answers by request, and the calls.
fn play(answers: &[(usize, Vec<usize>)], steps: &[Step]) -> (Vec<Vec<String>>, Vec<String>) {
    let script = Shared::new(Mutex::new(Script::default()));
    for (codel, events) in answers {
        let answer = |event: &usize| Answer { event: EVENTS[*event].into(), detail: None };
        // The last answer is repeated: it is one that lets activities end.
        let mut list: Vec<Answer> = events.iter().map(answer).collect();
        list.push(Answer { event: "ether".into(), detail: None });
        script.lock().unwrap().answers.insert(CODELS[*codel].into(), list);
    }
    let clock = Arc::new(VirtualClock::new());
    static PLAN: OnceLock<Arc<Plan>> = OnceLock::new();
    let plan = Arc::clone(PLAN.get_or_init(|| support::plan(GEN)));
    let body = Arc::new(Scripted {
        plan: Arc::clone(&plan),
        script: Arc::clone(&script),
        clock: Arc::clone(&clock),
    });
    let mut options = Options::new("demo", Arc::new(Nobody));
    options.clock = Clock::Virtual(Arc::clone(&clock));
    options.activity_limit = 3;
    let instance = Instance::start(Arc::clone(&plan), body, options).unwrap();
    let replies = Arc::new(Mutex::new(Vec::<Vec<String>>::new()));
    for step in steps {
        match step {
            Step::Request(service) => {
                let rank = plan.service(SERVICES[*service]).unwrap();
                let number = {
                    let mut replies = replies.lock().unwrap();
                    replies.push(Vec::new());
                    replies.len() - 1
                };
                let replies = Arc::clone(&replies);
                let input = genom_runtime::input_record(&plan, rank).unwrap().unwrap();
                let reply = Box::new(move |progress| {
                    let text = match progress {
                        Progress::Accepted { .. } => "accepted".into(),
                        Progress::Ended(outcome) => format!("{outcome:?}"),
                    };
                    replies.lock().unwrap()[number].push(text);
                });
                instance.request(rank, input, reply);
            }
            Step::Abort(id) => {
                let _ = instance.abort(*id);
            }
            Step::Fire => instance.fire(0).unwrap(),
            Step::Advance(ms) => clock.step(Duration::from_millis(*ms)),
        }
    }
    instance.shutdown(Duration::from_secs(60)).unwrap();
    assert!(instance.activities().is_empty());
    let trace = script.lock().unwrap().trace.clone();
    let replies = replies.lock().unwrap().clone();
    (replies, trace)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    // genom3.md 7.3, 7.5, 7.7: equal inputs give equal calls.
    #[test]
    fn every_request_is_answered_once_and_a_replay_is_the_same(
        answers in proptest::collection::vec(
            (0..CODELS.len(), proptest::collection::vec(0..EVENTS.len(), 0..6)), 0..9),
        steps in proptest::collection::vec(step(), 0..40),
    ) {
        let (replies, trace) = play(&answers, &steps);
        for replies in &replies {
            let (last, before) = replies.split_last().unwrap();
            prop_assert!(last != "accepted", "{replies:?}");
            prop_assert!(before.len() <= 1 && before.iter().all(|reply| reply == "accepted"));
        }
        prop_assert_eq!((replies, trace), play(&answers, &steps));
    }
}
