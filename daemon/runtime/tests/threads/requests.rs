//! Requests at the same time as codels that block.

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
