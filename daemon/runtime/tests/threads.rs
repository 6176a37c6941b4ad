//! Rules that need real threads and real time: what blocks, what waits, what hangs.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_runtime::{Change, StartError, Watcher};
use support::closures::{Closures, Codel, Keeper, LONG, gate, next, request};

fn codel(work: impl Fn() -> &'static str + Send + Sync + 'static) -> Codel {
    Arc::new(work)
}

#[test]
fn a_blocked_function_holds_up_only_what_conflicts_with_it() {
    // Issue C, point 1: order is kept per service.
    let (gate, keeper) = gate();
    let order = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&order);
    let body = Closures::new(
        "component test {
           ids { long a, b; };
           function slow() { codel block(out a); };
           function other() { codel quick(out b); };
           function same() { codel conflicting(in a); };
           attribute get_b(out b);
           task t { };
           activity job() { task t; codel<start> work() yield ether; };
         };",
        &[
            (
                "block",
                codel(move || {
                    gate.pass();
                    "ok"
                }),
            ),
            (
                "conflicting",
                codel(move || {
                    noted.lock().unwrap().push("conflicting");
                    "ok"
                }),
            ),
            ("work", codel(|| "ether")),
        ],
    );
    let instance = body.start();
    let slow = request(&instance, "slow");
    keeper.wait();
    let second_slow = request(&instance, "slow");
    let same = request(&instance, "same");
    for service in ["other", "get_b", "other"] {
        assert_eq!(next(&request(&instance, service)), "done");
    }
    let job = request(&instance, "job");
    assert_eq!(next(&job), "accepted 2");
    assert_eq!(next(&job), "done");
    // None of these can have gone on.
    assert!(slow.try_recv().is_err() && second_slow.try_recv().is_err());
    assert!(same.try_recv().is_err() && order.lock().unwrap().is_empty());
    keeper.let_one_pass();
    assert_eq!(next(&slow), "done");
    keeper.let_one_pass();
    assert_eq!(next(&second_slow), "done");
    assert_eq!(next(&same), "done");
    instance.shutdown(LONG).unwrap();
}

/// A component of so many functions that block, and one that does not.
fn many(count: usize) -> (Arc<Closures>, Keeper) {
    let functions = (0..count).map(|n| format!("function f{n}() {{ codel block{n}(); }};"));
    let text = format!(
        "component test {{ {} function free() {{ codel quick(); }}; }};",
        functions.collect::<Vec<_>>().join(" ")
    );
    let (gate, keeper) = gate();
    let gate = Arc::new(gate);
    let names: Vec<String> = (0..count).map(|n| format!("block{n}")).collect();
    let block = || {
        let gate = Arc::clone(&gate);
        codel(move || {
            gate.pass();
            "ok"
        })
    };
    let codels: Vec<(&str, Codel)> = names.iter().map(|name| (name.as_str(), block())).collect();
    (Closures::new(&text, &codels), keeper)
}

#[test]
fn a_request_is_served_however_many_others_block() {
    // genom3.md 7.3, and better: only what conflicts waits.
    let (body, keeper) = many(40);
    let instance = body.start();
    let blocked: Vec<_> = (0..40).map(|n| request(&instance, &format!("f{n}"))).collect();
    (0..40).for_each(|_| keeper.wait());
    assert_eq!(next(&request(&instance, "free")), "done");
    (0..40).for_each(|_| keeper.let_one_pass());
    assert!(blocked.iter().all(|reply| next(reply) == "done"));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn requests_beyond_the_most_that_are_served_at_once_wait_and_none_is_lost() {
    // genom3.md 7.3: every request gets its final reply.
    let most = genom_runtime::plan::MOST_CONTROL_WORKERS;
    let (body, keeper) = many(most + 20);
    let instance = body.start();
    let all: Vec<_> = (0..most + 20)
        .flat_map(|n| {
            let name = format!("f{n}");
            [request(&instance, &name), request(&instance, &name)]
        })
        .collect();
    (0..most).for_each(|_| keeper.wait());
    assert!(all.iter().all(|reply| reply.try_recv().is_err()), "none has gone on");
    (0..all.len()).for_each(|_| keeper.let_one_pass());
    assert!(all.iter().all(|reply| next(reply) == "done"));
    instance.shutdown(LONG).unwrap();
}

#[test]
fn requests_of_one_service_are_served_in_order_of_arrival() {
    let body = Closures::new("component test { function f() { codel c(); }; };", &[]);
    let instance = body.start();
    let (sender, order) = channel();
    let rank = instance.plan().service("f").unwrap();
    for number in 0..200 {
        let sender = sender.clone();
        let input = genom_runtime::input_record(instance.plan(), rank).unwrap().unwrap();
        let reply = Box::new(move |_| sender.send(number).unwrap());
        instance.request(rank, input, reply);
    }
    let order: Vec<i32> = (0..200).map(|_| order.recv_timeout(LONG).unwrap()).collect();
    assert_eq!(order, (0..200).collect::<Vec<_>>());
    instance.shutdown(LONG).unwrap();
}

#[test]
fn a_periodic_task_ticks_and_its_figures_say_so() {
    // genom3.md 7.4: one pass a tick, pauses end on ticks.
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
    assert!(serde_json::to_string(&statistics).unwrap().contains("p99_ns"));
}

#[test]
fn a_codel_longer_than_its_period_latches_one_tick() {
    // genom3.md 7.4: no burst of catch-up ticks.
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
    // Ten periods pass within the second call; this waits on the clock, not for the engine.
    let begin = std::time::Instant::now();
    while begin.elapsed() < Duration::from_millis(20) {
        std::thread::park_timeout(Duration::from_millis(1));
    }
    keeper.let_one_pass();
    // The latched tick comes at once; a burst would need the gate ten times.
    keeper.wait();
    // A busy machine may have let the task sleep through some before.
    let ticks = std::iter::from_fn(|| overran.recv_timeout(LONG).ok()).find(|ticks| *ticks >= 9);
    let ticks = ticks.expect("nine ticks that came while it was at work");
    assert_eq!(calls.load(Ordering::SeqCst), 3);
    drop(keeper);
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
fn a_stop_request_waits_for_the_codel_and_forgets_what_it_yields() {
    // genom3.md 7.5: a codel that is executing finishes; its state is forgotten, unless it just
    // ended the activity.
    for (yielded, ends) in [("main", ["halt"].as_slice()), ("ether", &[])] {
        let (gate, keeper) = gate();
        let calls = Arc::new(Mutex::new(Vec::new()));
        let note = |name: &'static str, event: &'static str| {
            let calls = Arc::clone(&calls);
            codel(move || {
                calls.lock().unwrap().push(name);
                event
            })
        };
        let body = Closures::new(
            "component test {
               task t { };
               activity job() {
                 task t;
                 codel<start> work() yield main, ether;
                 codel<main> more() yield ether;
                 codel<stop> halt() yield ether;
               };
             };",
            &[
                (
                    "work",
                    codel(move || {
                        gate.pass();
                        yielded
                    }),
                ),
                ("more", note("more", "ether")),
                ("halt", note("halt", "ether")),
            ],
        );
        let instance = body.start();
        let job = request(&instance, "job");
        assert_eq!(next(&job), "accepted 2");
        keeper.wait();
        instance.abort(2).unwrap();
        keeper.let_one_pass();
        assert_eq!(next(&job), "done");
        assert_eq!(*calls.lock().unwrap(), ends);
        instance.shutdown(LONG).unwrap();
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
fn a_codel_that_never_returns_is_named_by_the_shutdown() {
    // genom3.md 7.7: such a codel blocks the shutdown; here for a limited time.
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
    // Another instance does not care.
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
    let wiring = Arc::new(Deaf);
    let mut options = genom_runtime::Options::new("test", wiring);
    options.start_timeout = Some(Duration::from_millis(20));
    let plan = Arc::clone(&body.plan);
    let (sender, started) = channel();
    std::thread::spawn(move || sender.send(genom_runtime::Instance::start(plan, body, options)));
    keeper.wait();
    // It hangs until the start has given up, which tries for some seconds to undo what it did.
    match started.recv_timeout(LONG).unwrap() {
        Err(StartError::Hangs { task, codel, .. }) => {
            assert_eq!((task.as_str(), codel.as_str()), ("t", "hang"));
        }
        other => panic!("{other:?}"),
    }
    drop(keeper);
}

struct Deaf;

impl genom_runtime::Wiring for Deaf {
    fn connect_port(&self, _: &str, _: &str) -> Result<(), genom_runtime::WiringError> {
        Ok(())
    }
    fn connect_service(&self, _: &str, _: &str) -> Result<(), genom_runtime::WiringError> {
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
    // It cannot have got in: the codel runs.
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

#[test]
fn codels_that_conflict_never_overlap_whatever_is_requested() {
    // genom3.md 4.5, with real tasks and requests.
    let inside = Arc::new(AtomicU64::new(0));
    let overlaps = Arc::new(AtomicU64::new(0));
    let touch = |event: &'static str| {
        let (inside, overlaps) = (Arc::clone(&inside), Arc::clone(&overlaps));
        codel(move || {
            overlaps.fetch_add(inside.fetch_add(1, Ordering::SeqCst), Ordering::SeqCst);
            std::thread::yield_now();
            inside.fetch_sub(1, Ordering::SeqCst);
            event
        })
    };
    let body = Closures::new(
        "component test {
           ids { long a; };
           task t { period 1 ms; codel<start> tick(inout a) yield pause::start; };
           task u { };
           function f() { codel fun(inout a); };
           function g() { codel gun(out a); };
           activity job() { task u; validate val(in ::a); codel<start> work(out a) yield ether; };
         };",
        &[
            ("tick", touch("pause::start")),
            ("fun", touch("ok")),
            ("gun", touch("ok")),
            ("val", touch("ok")),
            ("work", touch("ether")),
        ],
    );
    let instance = body.start();
    for _ in 0..100 {
        let pending = ["f", "g", "job", "f"].map(|service| request(&instance, service));
        for (receiver, answers) in pending.iter().zip([1, 1, 2, 1]) {
            for _ in 0..answers {
                let answer = next(receiver);
                assert!(answer == "done" || answer.starts_with("accepted"), "{answer}");
            }
        }
    }
    instance.shutdown(LONG).unwrap();
    assert_eq!(overlaps.load(Ordering::SeqCst), 0);
}
