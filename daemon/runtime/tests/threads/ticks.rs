//! Ticks, wake-ups and their statistics.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_runtime::{Change, Watcher};

use crate::support::closures::{Closures, LONG, codel, gate, next, request};

#[test]
fn a_periodic_task_ticks_and_its_figures_say_so() {
    // genom3.md 7.4: one pass per tick, pauses end at ticks.
    let (sender, ticks) = channel();
    let sender = Mutex::new(sender);
    let body = Closures::new(
        "component test { task t { period 1 ms; codel<start> c() yield pause::start; }; };",
        &[(
            "c",
            codel(move || {
                let _ = sender.lock().unwrap().send(());
                "pause::start"
            }),
        )],
    );
    let instance = body.start();
    for _ in 0..50 {
        ticks.recv_timeout(LONG).unwrap();
    }
    instance.shutdown(LONG).unwrap();
    let statistics = instance.statistics();
    let (task, codel) = (&statistics.tasks[0], &statistics.codels[0]);
    assert_eq!((task.name.as_str(), task.period_ns), ("t", Some(1_000_000)));
    assert!(task.lateness.count >= 49, "{task:?}");
    assert!(codel.durations.count >= 50 && codel.name == "c" && codel.owner == "t");
    assert!(task.cycles.p50_ns <= task.cycles.p99_ns && task.cycles.p99_ns <= task.cycles.max_ns);
}

#[test]
fn a_codel_longer_than_its_period_latches_one_tick() {
    // genom3.md 7.4: missed ticks are not caught up with.
    let (gate, keeper) = gate();
    let calls = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&calls);
    let (overruns, overran) = channel();
    let body = Closures::new(
        "component test { task t { period 2 ms; codel<start> c() yield pause::start; }; };",
        &[(
            "c",
            codel(move || {
                if counted.fetch_add(1, Ordering::SeqCst) >= 1 {
                    gate.pass();
                }
                "pause::start"
            }),
        )],
    );
    let instance = body.start_with(|options| {
        options.watcher = Some(Arc::new(Overruns(Mutex::new(overruns))));
    });
    keeper.wait();
    // Ten periods pass within the second call; this waits for the clock, not for the engine.
    let begin = std::time::Instant::now();
    while begin.elapsed() < Duration::from_millis(20) {
        std::thread::park_timeout(Duration::from_millis(1));
    }
    keeper.let_one_pass();
    // The latched tick comes at once; catching up would pass the gate ten times.
    keeper.wait();
    assert_eq!(calls.load(Ordering::SeqCst), 3);
    drop(keeper);
    // On a busy machine the task may have overslept some ticks before.
    let ticks = std::iter::from_fn(|| overran.recv_timeout(LONG).ok()).find(|ticks| *ticks >= 9);
    let ticks = ticks.expect("nine ticks that came while it was at work");
    instance.shutdown(LONG).unwrap();
    let statistics = instance.statistics();
    assert!(statistics.tasks[0].overruns >= ticks);
}

struct Overruns(Mutex<std::sync::mpsc::Sender<u64>>);

impl Watcher for Overruns {
    fn changed(&self, change: &Change) {
        if let Change::Overrun { ticks, .. } = change {
            let _ = self.0.lock().unwrap().send(*ticks);
        }
    }
}

#[test]
fn a_call_above_its_wcet_is_counted() {
    // genom3.md D.
    let body = Closures::new(
        "component test {
           task t { };
           activity slow() { task t; codel<start> spin() yield ether wcet 1 us; };
           activity fast() { task t; codel<start> run() yield ether wcet 1000 s; };
         };",
        &[
            (
                "spin",
                codel(|| {
                    let begin = std::time::Instant::now();
                    while begin.elapsed() < Duration::from_micros(5) {
                        std::hint::spin_loop();
                    }
                    "ether"
                }),
            ),
            ("run", codel(|| "ether")),
        ],
    );
    let instance = body.start();
    for service in ["slow", "slow", "fast"] {
        let receiver = request(&instance, service);
        next(&receiver);
        assert_eq!(next(&receiver), "done");
    }
    let statistics = instance.statistics();
    let counted: Vec<_> =
        statistics.codels.iter().map(|c| (c.name.as_str(), c.wcet_ns, c.above_wcet)).collect();
    assert_eq!(counted, [("spin", Some(1000), 2), ("run", Some(1_000_000_000_000), 0)]);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn an_external_event_wakes_an_aperiodic_task() {
    // dialects.md A.
    let body = Closures::new(
        "component test {
           event main;
           exception E { long code; };
           task t { };
           activity job() {
             task t;
             codel<start> first() yield pause::start;
             codel<main> last() yield ether;
             throw E;
           };
         };",
        &[("first", codel(|| "pause::start")), ("last", codel(|| "E"))],
    );
    let instance = body.start();
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    while instance.activities().iter().all(|activity| !activity.paused) {
        std::thread::yield_now();
    }
    instance.fire(0).unwrap();
    assert_eq!(next(&job), "::test::E {\"code\":1}");
    assert_eq!(instance.fire(1).unwrap_err().known, 1);
    instance.shutdown(LONG).unwrap();
}

#[test]
fn the_state_port_is_written_at_least_once_a_second() {
    // genom3.md 4.8: also when nothing happens.
    let body = Closures::new("component test { };", &[]);
    let instance = body.start();
    let first = body.states.load(Ordering::SeqCst);
    let begin = std::time::Instant::now();
    while body.states.load(Ordering::SeqCst) < first + 2 {
        assert!(begin.elapsed() < LONG, "no second write");
        std::thread::park_timeout(Duration::from_millis(20));
    }
    instance.shutdown(LONG).unwrap();
}
