//! Codels that do not return: what is reported while they run, and what continues without them.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use genom_runtime::{Clock, VirtualClock};
use support::closures::{Closures, Codel, Keeper, LONG, codel, gate, next, request, until};

/// A codel that waits at a gate, then returns `event`.
fn waits(event: &'static str) -> (Codel, Keeper) {
    let (gate, keeper) = gate();
    let codel = codel(move || {
        gate.pass();
        event
    });
    (codel, keeper)
}

#[test]
fn ticks_are_missed_while_a_codel_does_not_return_and_none_is_counted_twice() {
    let (hang, keeper) = waits("pause::start");
    let body = Closures::new(
        "component test {
           task t { period 1 ms; codel<start> first() yield main;
                    codel<main> hang() yield pause::start; };
         };",
        &[("first", codel(|| "main")), ("hang", hang)],
    );
    let instance = body.start();
    let missed = || instance.statistics().tasks[0].overruns;
    keeper.wait();
    // The thread is in the codel, so it cannot have reported anything.
    let mut last = missed();
    until("a hundred ticks are missed", || missed() >= last + 100);
    for _ in 0..1000 {
        let now = missed();
        assert!(now >= last, "{now} after {last}");
        last = now;
    }
    let before = Instant::now();
    let at_least = missed();
    keeper.let_one_pass();
    keeper.wait();
    let total = missed();
    let after = before.elapsed().as_millis();
    assert!(total >= at_least, "{total} after {at_least}");
    assert!(u128::from(total) <= u128::from(at_least) + after + 1, "{at_least}, then {total}");
    drop(keeper);
    instance.shutdown(LONG).unwrap();
    // It does not tick any more: nothing is missed.
    let last = missed();
    std::thread::park_timeout(Duration::from_millis(20));
    assert_eq!(missed(), last);
}

/// A task that hangs in an activity, one that ticks, one that is quick, and functions.
fn hanging() -> (genom_runtime::Instance, Keeper, Arc<AtomicU64>) {
    let (hang, keeper) = waits("ether");
    let ticks = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&ticks);
    let body = Closures::new(
        "component test {
           ids { long a, b; };
           task slow { };
           task steady { period 1 ms; codel<start> tick(inout b) yield pause::start; };
           activity job() { task slow; codel<start> hang(inout a) yield ether; };
           function free() { codel quick(); };
           function same() { codel held_up(in a); };
           attribute set(in a);
         };",
        &[
            ("hang", hang),
            (
                "tick",
                codel(move || {
                    counted.fetch_add(1, Ordering::Relaxed);
                    "pause::start"
                }),
            ),
        ],
    );
    let instance = body.start_with(|options| options.stuck_after = Duration::from_millis(50));
    let _job = request(&instance, "job");
    keeper.wait();
    until("the codel is stuck", || instance.stuck().is_some());
    (instance, keeper, ticks)
}

#[test]
fn a_stuck_codel_is_named_with_its_owner_and_task_until_it_returns() {
    let (instance, keeper, _) = hanging();
    let stuck = instance.stuck().unwrap();
    assert_eq!((stuck.codel.as_str(), stuck.owner.as_str()), ("hang", "job"));
    assert_eq!(stuck.task.as_deref(), Some("slow"));
    assert!(stuck.for_ns >= 50_000_000, "{stuck:?}");
    let figures = instance.statistics().tasks;
    assert_eq!(figures[0].stuck.as_ref().map(|one| one.call()), Some(stuck.call()));
    assert_eq!(figures[1].stuck, None);
    keeper.let_one_pass();
    until("it returned", || instance.stuck().is_none());
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_codel_that_says_how_long_it_takes_is_believed() {
    let (hang, keeper) = waits("ok");
    let body = Closures::new(
        "component test { function f() { codel hang() wcet 1000000 ms; }; };",
        &[("hang", hang)],
    );
    let instance = body.start_with(|options| options.stuck_after = Duration::ZERO);
    let answer = request(&instance, "f");
    keeper.wait();
    until("it runs", || instance.running_codels().iter().any(|one| one.for_ns > 0));
    assert_eq!(instance.stuck(), None);
    keeper.let_one_pass();
    assert_eq!(next(&answer), "done");
}

#[test]
fn to_exclude_everything_fails_when_a_codel_is_stuck_and_holds_up_nobody_else() {
    let (instance, keeper, ticks) = hanging();
    let before = ticks.load(Ordering::Relaxed);
    for _ in 0..1000 {
        let error = instance.exclusively(|_| panic!("a codel runs")).unwrap_err();
        assert_eq!(error.by.as_ref().map(|by| by.codel.as_str()), Some("hang"));
        let told = error.to_string();
        assert!(told.starts_with("test is held up: codel hang of job has been running"), "{told}");
    }
    until("the other task ticks on", || ticks.load(Ordering::Relaxed) > before);
    keeper.let_one_pass();
    until("it returned", || instance.stuck().is_none());
    instance.exclusively(|_| {}).unwrap();
    instance.shutdown(LONG).unwrap();
}

#[test]
fn while_one_waits_to_exclude_everything_the_others_go_on() {
    // It never counts as stuck: it is waited for, but other requests do not queue behind the
    // waiter.
    let (hang, keeper) = waits("ether");
    let ticks = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&ticks);
    let body = Closures::new(
        "component test {
           ids { long a, b; };
           task slow { };
           task steady { period 1 ms; codel<start> tick(inout b) yield pause::start; };
           activity job() { task slow; codel<start> hang(inout a) yield ether; };
         };",
        &[
            ("hang", hang),
            (
                "tick",
                codel(move || {
                    counted.fetch_add(1, Ordering::Relaxed);
                    "pause::start"
                }),
            ),
        ],
    );
    let instance = Arc::new(body.start_with(|options| options.stuck_after = LONG));
    let job = request(&instance, "job");
    keeper.wait();
    let other = Arc::clone(&instance);
    let waiting = std::thread::spawn(move || other.exclusively(|_| {}));
    let before = ticks.load(Ordering::Relaxed);
    until("the other task ticks on", || ticks.load(Ordering::Relaxed) > before + 200);
    assert!(!waiting.is_finished());
    keeper.let_one_pass();
    waiting.join().unwrap().unwrap();
    assert_eq!((next(&job), next(&job)), ("accepted 3".into(), "done".into()));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_request_behind_a_stuck_codel_can_be_given_up_and_never_runs() {
    let ran = Arc::new(AtomicU64::new(0));
    let (hang, keeper) = waits("ether");
    let noted = Arc::clone(&ran);
    let body = Closures::new(
        "component test {
           ids { long a; };
           task slow { };
           activity job() { task slow; codel<start> hang(inout a) yield ether; };
           function free() { codel quick(); };
           function same() { codel held_up(in a); };
         };",
        &[
            ("hang", hang),
            (
                "held_up",
                codel(move || {
                    noted.fetch_add(1, Ordering::SeqCst);
                    "ok"
                }),
            ),
        ],
    );
    let instance = body.start_with(|options| options.stuck_after = Duration::from_millis(20));
    let _job = request(&instance, "job");
    keeper.wait();
    until("the codel is stuck", || instance.stuck().is_some());
    let ask = |service: &str| {
        let rank = instance.plan().service(service).unwrap();
        let input = genom_runtime::input_record(instance.plan(), rank).unwrap().unwrap();
        let (sender, answers) = std::sync::mpsc::channel();
        let sender = Mutex::new(sender);
        let reply = Box::new(move |progress| {
            let _ = sender.lock().unwrap().send(format!("{progress:?}"));
        });
        (rank, instance.request(rank, input, reply), answers)
    };
    let (_, free, answer) = ask("free");
    answer.recv_timeout(LONG).unwrap();
    assert!(free.has_begun());
    // One is being served and waits for the exclusion, the other one is queued behind it.
    let both = [ask("same"), ask("same")];
    for (rank, ticket, _) in &both {
        let held_up = instance.give_up(*rank, ticket).unwrap();
        assert_eq!(held_up.by.unwrap().codel, "hang");
    }
    keeper.let_one_pass();
    let (_, _, answer) = ask("same");
    answer.recv_timeout(LONG).unwrap();
    assert_eq!(ran.load(Ordering::SeqCst), 1, "only the last of the three ran");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn stop_codels_of_other_tasks_run_although_one_hangs() {
    // genom3.md 7.7: other tasks still stop properly.
    let (hang, keeper) = waits("ether");
    let stopped = Arc::new(AtomicU64::new(0));
    let noted = Arc::clone(&stopped);
    let body = Closures::new(
        "component test {
           task slow { };
           task clean { period 1 ms; codel<start> idle() yield ether;
                        codel<stop> stop() yield ether; };
           activity job() { task slow; codel<start> hang() yield ether; };
         };",
        &[
            ("hang", hang),
            ("idle", codel(|| "ether")),
            (
                "stop",
                codel(move || {
                    noted.fetch_add(1, Ordering::SeqCst);
                    "ether"
                }),
            ),
        ],
    );
    let instance = body.start_with(|options| options.stuck_after = Duration::from_millis(20));
    let _job = request(&instance, "job");
    keeper.wait();
    let ended = Arc::new(AtomicU64::new(0));
    let told = Arc::clone(&ended);
    let tell = Box::new(move || {
        told.fetch_add(1, Ordering::SeqCst);
    });
    assert!(instance.begin_shutdown(tell, LONG));
    until("the stop codel ran", || stopped.load(Ordering::SeqCst) == 1);
    let error = instance.finish_shutdown(Instant::now()).unwrap_err();
    assert_eq!(error.codels[0].codel, "hang");
    assert!(!instance.is_over());
    assert_eq!(ended.load(Ordering::SeqCst), 0);
    // What was left behind ends when its codel returns, and this is reported.
    drop(keeper);
    until("it is over", || instance.is_over());
    until("that is told", || ended.load(Ordering::SeqCst) == 1);
}

#[test]
fn a_shutdown_does_not_wait_for_ticks() {
    // Waiting for ticks would take hours, in each of three steps.
    let body = Closures::new(
        "component test {
           task t { period 10000 s; codel<start> c() yield pause::start;
                    codel<stop> s() yield ether; };
           task u { period 10000 s; };
         };",
        &[("c", codel(|| "pause::start")), ("s", codel(|| "ether"))],
    );
    body.start().shutdown(LONG).unwrap();
}

#[test]
fn a_clock_whose_step_does_not_return_does_not_hang_a_shutdown() {
    let (hang, keeper) = waits("ether");
    let body = Closures::new(
        "component test {
           task t { period 1 ms; };
           activity job() { task t; codel<start> hang() yield ether; };
         };",
        &[("hang", hang)],
    );
    let clock = Arc::new(VirtualClock::new());
    let instance = body.start_with(|options| {
        options.clock = Clock::Virtual(Arc::clone(&clock));
        options.stuck_after = Duration::from_millis(20);
    });
    let _job = request(&instance, "job");
    let stepping = std::thread::spawn(move || clock.step(Duration::from_millis(10)));
    keeper.wait();
    // Its virtual time stands still; the real time of the waiting thread does not.
    until("the codel is stuck", || instance.stuck().is_some());
    let error = instance.shutdown(Duration::from_millis(50)).unwrap_err();
    assert_eq!(error.codels[0].codel, "hang");
    assert!(!instance.is_over(), "the thread that steps is still in its codel");
    drop(keeper);
    stepping.join().unwrap();
    assert!(instance.is_over());
}

#[test]
fn who_waits_for_what_hangs_is_answered_when_it_is_left_behind_and_not_again() {
    let ((hang, keeper), (block, blocker)) = (waits("ether"), waits("ok"));
    let body = Closures::new(
        "component test {
           task slow { };
           activity job() { task slow; codel<start> hang() yield ether; };
           function f() { codel block(); };
         };",
        &[("hang", hang), ("block", block)],
    );
    let instance = body.start_with(|options| options.stuck_after = Duration::from_millis(50));
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    keeper.wait();
    let [served, queued] = [request(&instance, "f"), request(&instance, "f")];
    blocker.wait();
    let error = instance.shutdown(Duration::from_millis(200)).unwrap_err();
    assert_eq!(error.codels.len(), 2);
    let killed = "::genom::interrupted {\"by\":\"kill\"}";
    assert_eq!([next(&job), next(&served), next(&queued)], [killed; 3]);
    keeper.let_one_pass();
    blocker.let_one_pass();
    until("both returned", || instance.is_over());
    for answers in [job, served, queued] {
        assert!(answers.try_recv().is_err(), "one answer a request");
    }
}
