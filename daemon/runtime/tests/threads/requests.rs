//! Requests at the same time as codels that block or conflict.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

use crate::support::closures::{Closures, Codel, Keeper, LONG, codel, gate, next, request};

#[test]
fn a_blocked_function_holds_up_only_what_conflicts_with_it() {
    // Requests of one service are served in order.
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
    // None of these can have continued.
    assert!(slow.try_recv().is_err() && second_slow.try_recv().is_err());
    assert!(same.try_recv().is_err() && order.lock().unwrap().is_empty());
    keeper.let_one_pass();
    assert_eq!(next(&slow), "done");
    keeper.let_one_pass();
    assert_eq!(next(&second_slow), "done");
    assert_eq!(next(&same), "done");
    instance.shutdown(LONG).unwrap();
}

/// A component with `count` functions that block, and one that does not.
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
    // genom3.md 7.3: only what conflicts waits.
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
fn a_stop_request_waits_for_the_codel_and_forgets_what_it_yields() {
    // genom3.md 7.5: a codel that is running finishes; the state it yields is dropped, unless it
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
