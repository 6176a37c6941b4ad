//! Moments at which a component rests, so that its code can be exchanged.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use genom_runtime::{Clock, NoRest, VirtualClock};
use support::closures::{Closures, Codel, LONG, codel, gate, next, request, until};

/// Raises a flag while a codel runs, which may not be raised while the component rests.
fn marks(running: &Arc<AtomicU64>, event: &'static str) -> Codel {
    let running = Arc::clone(running);
    codel(move || {
        running.fetch_add(1, Ordering::SeqCst);
        for _ in 0..200 {
            std::hint::spin_loop();
        }
        running.fetch_sub(1, Ordering::SeqCst);
        event
    })
}

#[test]
fn no_codel_runs_while_a_component_rests_not_even_an_async_one() {
    let running = Arc::new(AtomicU64::new(0));
    // With more nodes than a word has bits, another part of the exclusion does the same.
    for attributes in [0, 70] {
        let more: String = (0..attributes).map(|n| format!("attribute set{n}(in a{n});")).collect();
        let ids: String = (0..attributes).map(|n| format!("long a{n};")).collect();
        let body = Closures::new(
            &format!(
                "component test {{
                   ids {{ long b; {ids} }};
                   task quick {{ period 1 ms; codel<start> tick(inout b) yield pause::start; }};
                   task slow {{ period 1 ms; async codel<start> work() yield pause::start; }};
                   {more}
                   function f() {{ codel quick(in b); }};
                 }};"
            ),
            &[
                ("tick", marks(&running, "pause::start")),
                ("work", marks(&running, "pause::start")),
                ("quick", marks(&running, "ok")),
            ],
        );
        let instance = body.start();
        for _ in 0..100 {
            let asked = request(&instance, "f");
            let seen = instance.at_rest(LONG, |_| {
                let before = running.load(Ordering::SeqCst);
                std::thread::park_timeout(Duration::from_micros(300));
                (before, running.load(Ordering::SeqCst))
            });
            assert_eq!(seen, Ok((0, 0)));
            assert_eq!(next(&asked), "done");
        }
        instance.shutdown(LONG).unwrap();
    }
}

#[test]
fn each_activity_is_at_a_pause_while_a_component_rests() {
    for period in ["period 1 ms;", ""] {
        // Between two states without pause the count is odd. Each instance has its own: a shutdown
        // may come between the two.
        let count = Arc::new(AtomicU64::new(0));
        let counts = |event| {
            let count = Arc::clone(&count);
            codel(move || {
                count.fetch_add(1, Ordering::SeqCst);
                event
            })
        };
        let body = Closures::new(
            &format!(
                "component test {{
                   task t {{ {period} codel<start> one() yield main;
                             codel<main> two() yield pause::start; }};
                   function wake() {{ codel nothing(); }};
                 }};"
            ),
            &[("one", counts("main")), ("two", counts("pause::start"))],
        );
        let instance = body.start();
        let mut seen = Vec::new();
        for _ in 0..200 {
            let _asked = request(&instance, "wake");
            seen.push(instance.at_rest(LONG, |_| count.load(Ordering::SeqCst)).unwrap());
        }
        assert!(seen.iter().all(|count| count % 2 == 0), "{seen:?}");
        until("it works", || count.load(Ordering::SeqCst) > seen[0]);
        instance.shutdown(LONG).unwrap();
    }
}

#[test]
fn a_codel_that_does_not_return_is_named_and_all_others_go_on() {
    let (gate, keeper) = gate();
    let ticks = Arc::new(AtomicU64::new(0));
    let counted = Arc::clone(&ticks);
    let body = Closures::new(
        "component test {
           task steady { period 1 ms; codel<start> tick() yield pause::start; };
           task slow { };
           activity job() { task slow; async codel<start> hang() yield ether; };
         };",
        &[
            (
                "hang",
                codel(move || {
                    gate.pass();
                    "ether"
                }),
            ),
            (
                "tick",
                codel(move || {
                    counted.fetch_add(1, Ordering::Relaxed);
                    "pause::start"
                }),
            ),
        ],
    );
    let instance = body.start_with(|options| options.stuck_after = LONG);
    let job = request(&instance, "job");
    keeper.wait();
    let before = ticks.load(Ordering::Relaxed);
    let refused = instance.at_rest(Duration::from_millis(50), |_| panic!("a codel runs"));
    let Err(NoRest::HeldUp(told)) = &refused else { panic!("{refused:?}") };
    assert!(told.to_string().contains("codel hang of job has been running"), "{told}");
    assert!(ticks.load(Ordering::Relaxed) > before, "the other task went on");
    keeper.let_one_pass();
    assert_eq!([next(&job), next(&job)], ["accepted 3", "done"]);
    instance.at_rest(LONG, |_| {}).unwrap();
    instance.shutdown(LONG).unwrap();
    let stops = NoRest::Stops { instance: "test".to_owned() };
    assert_eq!(instance.at_rest(LONG, |_| {}), Err(stops));
}

#[test]
fn a_task_that_never_pauses_is_named() {
    let over = Arc::new(AtomicBool::new(false));
    let may_end = Arc::clone(&over);
    let body = Closures::new(
        "component test {
           task t { };
           activity job() { task t; codel<start> spin() yield start, ether; };
         };",
        &[("spin", codel(move || if may_end.load(Ordering::Relaxed) { "ether" } else { "start" }))],
    );
    let instance = body.start();
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    until("it spins", || instance.statistics().codels.iter().any(|one| one.durations.count > 9));
    let refused = instance.at_rest(Duration::from_millis(20), |_| panic!("it spins"));
    let (instance_name, task) = ("test".to_owned(), "t".to_owned());
    assert_eq!(refused, Err(NoRest::NoPause { instance: instance_name, task }));
    over.store(true, Ordering::Relaxed);
    assert_eq!(next(&job), "done");
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_component_on_a_virtual_clock_rests_between_two_steps() {
    let body = Closures::new(
        "component test { task t { period 1 ms; codel<start> tick() yield pause::start; }; };",
        &[("tick", codel(|| "pause::start"))],
    );
    let clock = Arc::new(VirtualClock::new());
    let instance = body.start_with(|options| options.clock = Clock::Virtual(Arc::clone(&clock)));
    clock.step(Duration::from_millis(3));
    instance.at_rest(LONG, |rest| assert!(rest.is_of(rest.body()))).unwrap();
    clock.step(Duration::from_millis(3));
    instance.shutdown(LONG).unwrap();
}
