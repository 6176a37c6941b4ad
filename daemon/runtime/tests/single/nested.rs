//! Codels that call services of components of the same thread.

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, OnceLock};

use genom_runtime::{CannotWait, Instance};

use crate::support::closures::{Closures, LONG, codel, next, request};
use crate::support::{shared, start_on};

type Peer = Arc<OnceLock<Arc<Instance>>>;

#[test]
fn a_codel_gets_the_answer_of_a_function_and_is_refused_an_activity_and_what_excludes_it() {
    let executor = shared();
    let provider = Closures::new(
        "component test {
           task t { };
           function f() { codel g(); };
           activity job() { task t; codel<start> work() yield ether; };
         };",
        &[("work", codel(|| "ether"))],
    );
    let provider = Arc::new(start_on(&executor, "provider", &provider));
    let (own, theirs): (Peer, Peer) = (Peer::default(), Peer::default());
    let (sender, told) = channel();
    let sender = Mutex::new(sender);
    let (me, other) = (Arc::clone(&own), Arc::clone(&theirs));
    let caller = Closures::new(
        "component test {
           ids { long a; };
           function call() { codel calls(inout a); };
           function conflicting() { codel reads(in a); };
           function free() { codel nothing(); };
         };",
        &[(
            "calls",
            codel(move || {
                let (me, other) = (me.get().unwrap(), other.get().unwrap());
                let may = |instance: &Instance, service: &str| {
                    instance.may_wait_here(instance.plan().service(service).unwrap())
                };
                let refused = [may(other, "job"), may(me, "conflicting"), may(me, "call")];
                may(other, "f").unwrap();
                may(me, "free").unwrap();
                let answers = [next(&request(other, "f")), next(&request(me, "free"))];
                sender.lock().unwrap().send((refused, answers)).unwrap();
                "ok"
            }),
        )],
    );
    let caller = Arc::new(start_on(&executor, "caller", &caller));
    assert!(own.set(Arc::clone(&caller)).is_ok() && theirs.set(Arc::clone(&provider)).is_ok());
    // Any other thread may wait.
    caller.may_wait_here(caller.plan().service("call").unwrap()).unwrap();
    assert_eq!(next(&request(&caller, "call")), "done");
    let (refused, answers) = told.recv_timeout(LONG).unwrap();
    assert_eq!(answers, ["done", "done"]);
    let [job, conflicting, again] = refused.map(Result::unwrap_err);
    assert!(matches!(&job, CannotWait::Activity { service, .. } if service == "job"));
    for (refused, wanted) in [(conflicting, "conflicting"), (again, "call")] {
        let CannotWait::Conflict { service, codel, .. } = refused else { panic!("{refused}") };
        assert_eq!((service.as_str(), codel.as_str()), (wanted, "calls"));
    }
    caller.shutdown(LONG).unwrap();
    provider.shutdown(LONG).unwrap();
}
