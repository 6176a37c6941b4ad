//! An instance as the daemon uses it: refusals, watching, overrides.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_description::model::{Ix as _, ServiceIx};
use genom_runtime::{
    ActivityPhase, Change, Clock, Instance, Outcome, Plan, PlanError, Progress, StartError,
    TaskOptions, VirtualClock, Watcher,
};
use genom_types::Record;
use support::closures::{Closures, Codel, LONG, next, request};

const GEN: &str = "component test {
  ids { long a; };
  exception E { long code; };
  task t { period 2 ms; };
  attribute set(in a = 4);
  function f(in double x, out double y) { codel c(in x, out y); };
  activity job() {
    task t;
    codel<start> first() yield main;
    codel<main> second() yield pause::main, ether;
    codel<stop> last() yield ether;
    throw E;
  };
};";

fn codel(event: &'static str) -> Codel {
    Arc::new(move || event)
}

fn answer(instance: &Instance, service: ServiceIx, input: Record) -> String {
    let (sender, receiver) = channel();
    let reply = Box::new(move |progress| {
        if let Progress::Ended(Outcome::Exception(exception)) = progress {
            let _ = sender.send(exception.to_string());
        }
    });
    instance.request(service, input, reply);
    receiver.recv_timeout(LONG).unwrap()
}

#[test]
fn inputs_of_another_service_are_refused_as_serialization() {
    // genom3.md 7.3.2.
    let body = Closures::new(GEN, &[]);
    let instance = body.start();
    let (set, f) = (body.plan.service("set").unwrap(), body.plan.service("f").unwrap());
    let input = Record::new(&body.plan.services()[f].input);
    assert_eq!(answer(&instance, set, input.clone()), "::genom::serialization");
    assert_eq!(answer(&instance, ServiceIx::new(1000), input), "::genom::no_such_service");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn inputs_start_from_the_defaults_of_the_gen() {
    // genom3.md 4.10: an input without default is zero.
    let plan = support::plan(GEN);
    let shown = |name| {
        let rank = plan.service(name).unwrap();
        genom_runtime::input_record(&plan, rank).unwrap().unwrap().to_json().to_string()
    };
    assert_eq!(shown("set"), "{\"a\":4}");
    assert_eq!(shown("f"), "{\"x\":0.0}");
    assert!(genom_runtime::input_record(&plan, ServiceIx::new(1000)).unwrap().is_none());
}

#[test]
fn a_component_that_is_not_there_is_no_plan() {
    let plan = support::plan(GEN);
    let error = Plan::new(plan.specification(), 7).unwrap_err();
    assert!(matches!(error, PlanError::NoComponent { component: 7, known: 1 }), "{error}");
}

#[test]
fn every_string_a_codel_may_return_is_an_event_of_the_plan() {
    // genom3.md 5.3.
    let plan = support::plan(GEN);
    for name in [
        "::test::start",
        "::test::pause::main",
        "::test::E",
        "::genom::bad_transition",
        "::genom::syserr",
        "::genom::unkex",
        "::genom::fatal",
    ] {
        let event = plan.event(name).unwrap_or_else(|| panic!("{name}"));
        assert_eq!(plan.event_name(event), name);
        assert_eq!(plan.event_names()[usize::from(event.0)], name);
    }
    assert_eq!(plan.event("::test::nothing"), None);
    assert_eq!(plan.contexts(), 1 + plan.services().len());
}

struct Changes(Mutex<Sender<Change>>);

impl Watcher for Changes {
    fn changed(&self, change: &Change) {
        let _ = self.0.lock().unwrap().send(change.clone());
    }
}

#[test]
fn a_watcher_sees_each_activity_from_acceptance_to_end_in_order() {
    let codels = [("first", codel("main")), ("second", codel("ether"))];
    let body = Closures::new(GEN, &codels);
    let (sender, changes) = channel();
    let instance = body.start_with(|options| {
        options.watcher = Some(Arc::new(Changes(Mutex::new(sender))));
    });
    for activity in 2..20 {
        let job = request(&instance, "job");
        assert_eq!(next(&job), format!("accepted {activity}"));
        assert_eq!(next(&job), "done");
        let service = body.plan.service("job").unwrap();
        let state = body.plan.component().state("main").unwrap();
        let mut seen = Vec::new();
        while !matches!(seen.last(), Some(Change::Ended { .. })) {
            let change = changes.recv_timeout(LONG).unwrap();
            if !matches!(change, Change::Overrun { .. }) {
                seen.push(change);
            }
        }
        assert_eq!(
            seen,
            [
                Change::Accepted { activity, service },
                Change::Moved { activity, state, paused: false },
                Change::Ended { activity, service, exception: None },
            ]
        );
    }
    instance.shutdown(LONG).unwrap();
    assert_eq!(instance.statistics().lost_changes, 0);
}

/// States that an activity was reported to move to, on a clock of its own; `stop` asks it to stop.
fn moves_when_stopped(stop: impl FnOnce(&Instance)) -> Vec<String> {
    let codels = [
        ("first", codel("main")),
        ("second", codel("pause::main")),
        ("last", codel("pause::stop")),
    ];
    let body = Closures::new(STOPS, &codels);
    let (sender, changes) = channel();
    let clock = Arc::new(VirtualClock::new());
    let instance = body.start_with(|options| {
        options.watcher = Some(Arc::new(Changes(Mutex::new(sender))));
        options.clock = Clock::Virtual(Arc::clone(&clock));
    });
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    let period = Duration::from_millis(2);
    clock.step(period);
    stop(&instance);
    clock.step(period);
    let states = &body.plan.component().states;
    let moves = changes.try_iter().filter_map(|change| match change {
        Change::Moved { activity: 2, state, paused } => {
            Some(format!("{}{}", states[state], if paused { ", paused" } else { "" }))
        }
        _ => None,
    });
    moves.collect()
}

const STOPS: &str = "component test {
  task t { period 2 ms; };
  activity job() {
    task t;
    codel<start> first() yield main;
    codel<main> second() yield pause::main, ether;
    codel<stop> last() yield pause::stop, ether;
  };
  function halt() { interrupts job; };
};";

#[test]
fn a_stop_shows_as_a_move_to_stop_whoever_asked_for_it() {
    // genom3.md 7.5: the activity jumps to `stop`, which no codel yielded.
    let seen = ["main", "main, paused", "stop", "stop, paused"];
    assert_eq!(moves_when_stopped(|instance| instance.abort(2).unwrap()), seen);
    let interrupted = |instance: &Instance| assert_eq!(next(&request(instance, "halt")), "done");
    assert_eq!(moves_when_stopped(interrupted), seen);
    let aborted = |instance: &Instance| {
        let rank = instance.plan().service("abort_activity").unwrap();
        let mut input = Record::new(&instance.plan().services()[rank].input);
        input.merge_json(&serde_json::json!({ "activity": 2 })).unwrap();
        instance.request(rank, input, Box::new(|_| {}));
    };
    assert_eq!(moves_when_stopped(aborted), seen);
}

#[test]
fn a_configuration_changes_the_period_of_a_task() {
    let body = Closures::new(GEN, &[("first", codel("main")), ("second", codel("pause::main"))]);
    let instance = body.start_with(|options| {
        let period = Some(Duration::from_millis(7));
        let task = TaskOptions { period, cpus: vec![0], ..Default::default() };
        options.tasks.insert("t".into(), task);
    });
    assert_eq!(instance.statistics().tasks[0].period_ns, Some(7_000_000));
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    // Activities are listed by id, state and phase.
    loop {
        let activities = instance.activities();
        let activity = activities.iter().find(|activity| activity.id == 2).unwrap();
        assert_eq!(activity.service.as_deref(), Some("job"));
        if activity.phase == ActivityPhase::Run && activity.state == "main" && activity.paused {
            break;
        }
        std::thread::yield_now();
    }
    instance.abort(2).unwrap();
    instance.shutdown(LONG).unwrap();
}

#[test]
fn an_instance_that_is_dropped_ends_its_threads() {
    let body = Closures::new(GEN, &[("first", codel("main")), ("second", codel("pause::main"))]);
    let instance = body.start();
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    drop(instance);
    // There is no stop codel, so the returned event is no transition.
    assert!(next(&job).starts_with("::genom::"), "the client is told");
    // The threads, which held the body, have ended.
    assert_eq!(Arc::strong_count(&body), 1);
}

#[test]
fn a_task_has_the_stack_that_its_description_gives_it() {
    // genom3.md 7.4: the default stack is 8 MB, which the codel here would overflow.
    let body = Closures::new(
        "component test {
           task t { stack 64 M; };
           activity deep() { task t; codel<start> dig() yield ether; };
         };",
        &[("dig", {
            Arc::new(|| {
                let room = std::hint::black_box([1u8; 12 << 20]);
                if room.iter().step_by(4096).all(|byte| *byte == 1) { "ether" } else { "start" }
            })
        })],
    );
    let instance = body.start();
    let deep = request(&instance, "deep");
    assert_eq!((next(&deep), next(&deep)), ("accepted 2".into(), "done".into()));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_task_that_gets_no_thread_undoes_the_start() {
    // genom3.md 7.2.3: no machine provides such a stack. What was started before is stopped.
    let (stopped, stops) = std::sync::mpsc::channel();
    let stopped = std::sync::Mutex::new(stopped);
    let body = Closures::new(
        "component test {
           task a { codel<start> a1() yield pause::start; codel<stop> a_stop() yield ether; };
           task b { stack 2000000000 M; };
         };",
        &[
            ("a1", codel("pause::start")),
            (
                "a_stop",
                Arc::new(move || {
                    stopped.lock().unwrap().send(()).unwrap();
                    "ether"
                }),
            ),
        ],
    );
    let error = body.try_start().unwrap_err();
    assert!(matches!(error, StartError::NoThread { .. }), "{error:?}");
    assert!(error.to_string().starts_with("task b of test has no thread: "), "{error}");
    assert_eq!(stops.try_iter().count(), 1);
    assert_eq!(Arc::strong_count(&body), 1, "nothing is left");
}
