//! A codel that does not return holds up all components of its thread, which is told.

use std::sync::Arc;
use std::time::Duration;

use genom_runtime::{Execution, Inputs, StartError, Ticket, input_record};

use crate::support::closures::{Closures, Keeper, LONG, codel, gate, next, request, until};
use crate::support::{shared, start_on};

fn quick() -> Arc<Closures> {
    Closures::new(
        "component test {
           task t { codel<start> begin() yield ether; };
           function f() { codel g(); };
         };",
        &[("begin", codel(|| "ether"))],
    )
}

/// A component with a function that waits at the gate.
fn holder() -> (Arc<Closures>, Keeper) {
    let (gate, keeper) = gate();
    let body = Closures::new(
        "component test { function hold() { codel hold(); }; };",
        &[(
            "hold",
            codel(move || {
                gate.pass();
                "ok"
            }),
        )],
    );
    (body, keeper)
}

#[test]
fn requests_to_the_others_are_refused_with_its_name_and_served_when_it_has_returned() {
    let executor = shared();
    let (body, keeper) = holder();
    let (holder, other) =
        (start_on(&executor, "holder", &body), start_on(&executor, "other", &quick()));
    let held = request(&holder, "hold");
    keeper.wait();
    let f = other.plan().service("f").unwrap();
    let ticket = Ticket::default();
    let input = input_record(other.plan(), f).unwrap().unwrap();
    other.request_by(&ticket, f, Inputs::Whole(input), Box::new(|_| {}));
    until("it is stuck", || holder.stuck().is_some());
    let told = other.give_up(f, &ticket).expect("it is held up").to_string();
    assert!(
        told.starts_with("other is held up: codel hold of holder/hold has been running for"),
        "{told}"
    );
    assert_eq!(other.stuck(), None, "none of its own codels is");
    let waits = request(&other, "f");
    keeper.let_one_pass();
    assert_eq!((next(&held), next(&waits)), ("done".into(), "done".into()));
    holder.shutdown(LONG).unwrap();
    other.shutdown(LONG).unwrap();
}

#[test]
fn components_that_start_or_stop_meanwhile_name_it() {
    let executor = shared();
    let (body, keeper) = holder();
    let (holder, other) =
        (start_on(&executor, "holder", &body), start_on(&executor, "other", &quick()));
    let held = request(&holder, "hold");
    keeper.wait();
    let late = quick();
    let error = late.try_start_with_options(|options| {
        options.execution = Execution::Single(Arc::clone(&executor));
        options.start_timeout = Some(Duration::from_millis(20));
    });
    let Err(StartError::HeldUp { by, .. }) = &error else { panic!("{error:?}") };
    assert_eq!((by.codel.as_str(), by.owner.as_str()), ("hold", "holder/hold"));
    let error = other.shutdown(Duration::from_millis(20)).unwrap_err();
    assert_eq!(
        error.codels.iter().map(|one| one.owner.as_str()).collect::<Vec<_>>(),
        ["holder/hold"]
    );
    keeper.let_one_pass();
    assert_eq!(next(&held), "done");
    // The thread has what it was asked to end meanwhile behind it.
    until("the other has ended", || other.is_over());
    holder.shutdown(LONG).unwrap();
}
