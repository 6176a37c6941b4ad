//! Many components on one thread: which thread runs what, and what comes and goes at run time.

use std::collections::HashSet;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread::ThreadId;

use genom_runtime::Execution;

use crate::support::closures::{Closures, Codel, LONG, codel, next, request};
use crate::support::{execution, shared, start_on};

#[test]
fn all_codels_of_all_components_run_on_one_thread() {
    let executor = shared();
    let threads = Arc::new(Mutex::new(HashSet::<ThreadId>::new()));
    let notes = |event: &'static str| -> Codel {
        let threads = Arc::clone(&threads);
        codel(move || {
            threads.lock().unwrap().insert(std::thread::current().id());
            event
        })
    };
    let body = Closures::new(
        "component test {
           task t { codel<start> begin() yield ether; codel<stop> end() yield ether; };
           task p { period 1 ms; codel<start> tick() yield pause::start; };
           function f() { codel fun(); };
           activity job() { task t; validate val(); codel<start> work() yield ether; };
         };",
        &[
            ("begin", notes("ether")),
            ("end", notes("ether")),
            ("tick", notes("pause::start")),
            ("fun", notes("ok")),
            ("val", notes("ok")),
            ("work", notes("ether")),
        ],
    );
    let instances: Vec<_> = (0..20).map(|n| start_on(&executor, &format!("m{n}"), &body)).collect();
    for instance in &instances {
        assert_eq!(next(&request(instance, "f")), "done");
        let job = request(instance, "job");
        assert!(next(&job).starts_with("accepted"));
        assert_eq!(next(&job), "done");
    }
    instances.iter().for_each(|instance| instance.shutdown(LONG).unwrap());
    assert_eq!(threads.lock().unwrap().len(), 1);
}

#[test]
fn components_come_and_go_while_others_tick_and_nothing_of_them_remains() {
    let executor = shared();
    let (sender, ticks) = channel();
    let sender = Mutex::new(sender);
    let steady = Closures::new(
        "component test { task t { period 1 ms; codel<start> c() yield pause::start; }; };",
        &[(
            "c",
            codel(move || {
                let _ = sender.lock().unwrap().send(());
                "pause::start"
            }),
        )],
    );
    let steady = start_on(&executor, "steady", &steady);
    let calls = Arc::new(Mutex::new(Vec::new()));
    let notes = |name: &'static str, event: &'static str| -> Codel {
        let calls = Arc::clone(&calls);
        codel(move || {
            calls.lock().unwrap().push(name);
            event
        })
    };
    let passing = Closures::new(
        "component test {
           task t { period 3600 s; codel<start> begin() yield pause::start;
                    codel<stop> end() yield ether; };
         };",
        &[("begin", notes("begin", "pause::start")), ("end", notes("end", "ether"))],
    );
    for _ in 0..20 {
        let instance = start_on(&executor, "passing", &passing);
        ticks.recv_timeout(LONG).unwrap();
        // Its tick is an hour away; the stop codel is not.
        instance.shutdown(LONG).unwrap();
        drop(instance);
        assert_eq!(Arc::strong_count(&passing), 1, "the thread has released it");
        let calls = std::mem::take(&mut *calls.lock().unwrap());
        assert_eq!((calls.first(), calls.last()), (Some(&"begin"), Some(&"end")), "{calls:?}");
    }
    steady.shutdown(LONG).unwrap();
}

#[test]
fn a_component_makes_the_same_sequence_of_calls_as_with_threads_of_its_own() {
    let sequence = |execution: Execution| {
        let calls = Arc::new(Mutex::new(Vec::new()));
        let notes = |name: &'static str, events: &'static [&'static str]| -> Codel {
            let (calls, rest) = (Arc::clone(&calls), Mutex::new(events.iter().cycle()));
            codel(move || {
                calls.lock().unwrap().push(name);
                rest.lock().unwrap().next().unwrap()
            })
        };
        let body = Closures::new(
            "component test {
               task t { codel<start> begin() yield main, ether; codel<main> loops() yield
                        pause::main, ether; codel<stop> tidy() yield ether; };
               function f() { codel fun(); };
               activity job() { task t; validate val();
                 codel<start> first() yield main, pause::main, ether;
                 codel<main> second() yield start, pause::start, ether;
                 codel<stop> halt() yield ether; };
             };",
            &[
                ("begin", notes("begin", &["main"])),
                ("loops", notes("loops", &["pause::main"])),
                ("tidy", notes("tidy", &["ether"])),
                ("fun", notes("fun", &["ok"])),
                ("val", notes("val", &["ok"])),
                ("first", notes("first", &["main", "ether", "main"])),
                ("second", notes("second", &["start", "ether"])),
                ("halt", notes("halt", &["ether"])),
            ],
        );
        let instance = body.start_with(|options| options.execution = execution);
        for _ in 0..8 {
            let job = request(&instance, "job");
            next(&job);
            assert_eq!(next(&job), "done");
        }
        instance.shutdown(LONG).unwrap();
        let mut all = calls.lock().unwrap().clone();
        // How often the permanent activity is woken depends on when others look.
        all.retain(|name| *name != "loops");
        all
    };
    let threads = sequence(Execution::Threads);
    assert!(threads.len() > 20, "{threads:?}");
    assert_eq!(sequence(execution()), threads);
}
