//! Codels that do not return, and those that wait for them.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use genom_runtime::StartError;

use crate::support::closures::{Closures, LONG, codel, gate, next, request, until};

#[test]
fn a_codel_that_never_returns_is_named_by_the_shutdown() {
    // genom3.md 7.7: such a codel blocks the shutdown; here only until the timeout.
    let (gate, keeper) = gate();
    let body = Closures::new(
        "component test {
           task t { };
           task u { codel<start> init() yield ether; codel<stop> tidy() yield ether; };
           activity job() { task t; codel<start> hang() yield ether; };
         };",
        &[
            ("init", codel(|| "ether")),
            ("tidy", codel(|| "ether")),
            (
                "hang",
                codel(move || {
                    gate.pass();
                    "ether"
                }),
            ),
        ],
    );
    let instance = body.start();
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 3");
    keeper.wait();
    let error = instance.shutdown(Duration::from_millis(100)).unwrap_err();
    assert_eq!(error.codels.iter().map(|one| one.codel.as_str()).collect::<Vec<_>>(), ["hang"]);
    let told = error.to_string();
    assert!(told.starts_with("test does not stop: codel hang of job has been running"), "{told}");
    // Another instance is not affected.
    let other = Closures::new("component test { function f() { codel c(); }; };", &[]).start();
    assert_eq!(next(&request(&other, "f")), "done");
    other.shutdown(LONG).unwrap();
    drop(keeper);
}

#[test]
fn a_start_codel_that_hangs_is_named_by_the_start() {
    let (gate, keeper) = gate();
    let body = Closures::new(
        "component test { task t { codel<start> hang() yield ether; }; };",
        &[(
            "hang",
            codel(move || {
                gate.pass();
                "ether"
            }),
        )],
    );
    let supervision = Arc::new(Deaf);
    let mut options = genom_runtime::Options::new("test", supervision);
    options.start_timeout = Some(Duration::from_millis(20));
    let plan = Arc::clone(&body.plan);
    let (sender, started) = channel();
    std::thread::spawn(move || sender.send(genom_runtime::Instance::start(plan, body, options)));
    keeper.wait();
    // It hangs until the start has given up, which takes some seconds of undoing.
    match started.recv_timeout(LONG).unwrap() {
        Err(StartError::Hangs { task, codel, .. }) => {
            assert_eq!((task.as_str(), codel.as_str()), ("t", "hang"));
        }
        other => panic!("{other:?}"),
    }
    drop(keeper);
}

struct Deaf;

impl genom_runtime::Supervision for Deaf {
    fn connect_port(&self, _: &str, _: &str) -> Result<(), genom_runtime::ConnectionError> {
        Ok(())
    }
    fn connect_service(&self, _: &str, _: &str) -> Result<(), genom_runtime::ConnectionError> {
        Ok(())
    }
    fn kill(&self) {}
}

#[test]
fn connecting_waits_until_no_codel_runs() {
    // genom3.md 7.8: connect_port excludes all codels.
    let (gate, keeper) = gate();
    let body = Closures::new(
        "component test {
           task t { };
           activity job() { task t; codel<start> work() yield ether; };
         };",
        &[(
            "work",
            codel(move || {
                gate.pass();
                "ether"
            }),
        )],
    );
    let instance = Arc::new(body.start());
    let job = request(&instance, "job");
    keeper.wait();
    let (sender, connected) = channel();
    let other = Arc::clone(&instance);
    let thread =
        std::thread::spawn(move || other.exclusively(|_| sender.send(()).unwrap()).unwrap());
    // It cannot have the exclusion: the codel runs.
    assert!(connected.recv_timeout(Duration::from_millis(20)).is_err());
    keeper.let_one_pass();
    connected.recv_timeout(LONG).unwrap();
    thread.join().unwrap();
    assert_eq!((next(&job), next(&job)), ("accepted 2".into(), "done".into()));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn an_async_codel_that_touches_no_port_does_not_hold_up_connecting() {
    // genom3.md 7.10: async codels may block for long without holding up other contexts.
    let (gate, keeper) = gate();
    let body = Closures::new(
        "component test {
           task t { };
           activity job() { task t; async codel<start> listen() yield ether; };
         };",
        &[(
            "listen",
            codel(move || {
                gate.pass();
                "ether"
            }),
        )],
    );
    let instance = body.start();
    let _job = request(&instance, "job");
    keeper.wait();
    instance.exclusively(|_| {}).unwrap();
    drop(keeper);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_permanent_activity_that_ends_while_it_is_asked_to_stop_runs_its_stop_codel() {
    // genom3.md 7.5: at shutdown `stop` always runs, even if the activity has ended.
    let (gate, keeper) = gate();
    let (stopped, stops) = channel();
    let stopped = std::sync::Mutex::new(stopped);
    let body = Closures::new(
        "component test {
           task t { codel<start> init() yield pause::main; codel<main> work() yield ether;
             codel<stop> tidy() yield ether; };
           function wake() { codel w(); };
         };",
        &[
            ("init", codel(|| "pause::main")),
            (
                "work",
                codel(move || {
                    gate.pass();
                    "ether"
                }),
            ),
            (
                "tidy",
                codel(move || {
                    let _ = stopped.lock().unwrap().send(());
                    "ether"
                }),
            ),
        ],
    );
    let instance = body.start();
    assert_eq!(next(&request(&instance, "wake")), "done");
    keeper.wait();
    assert!(instance.begin_shutdown(Box::new(|| ()), LONG));
    // In the second round from now it is asked to stop, while its codel is at work.
    if let Some(rounds) = instance.control_rounds() {
        until("a second round", || {
            instance.wake_control();
            instance.control_rounds().is_some_and(|now| now >= rounds + 2)
        });
    }
    keeper.let_one_pass();
    instance.finish_shutdown(Instant::now() + LONG).unwrap();
    stops.try_recv().expect("its stop codel ran");
}
