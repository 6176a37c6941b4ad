//! The order of requests and codels. Holds for tasks that share a thread as well, so that
//! `tests/single` has these tests, too.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

use crate::support::closures::{Closures, LONG, codel, gate, next, request};

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
