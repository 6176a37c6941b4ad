//! Requests and replies: functions, exceptions, activities, cancellation.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_types::Record;
use serde_json::{Value, json};

use crate::harness::{World, eventually};
use crate::samples::{note, number, numbered, other_state, state};
use genom_middleware::reply::{Reply, ReplyReceiver, pair};
use genom_middleware::{
    ActivityId, Address, CallError, Client, EndpointKind, Middleware, OpenError, Outcome, PortSpec,
    Publisher, Replies, Running, ServiceHandler, ServiceKind, ServiceType,
};

/// Enough for any middleware; only a failing test waits this long.
const PATIENCE: Duration = Duration::from_secs(30);

fn goto() -> Address {
    Address::new("demo", "goto")
}

fn service(kind: ServiceKind) -> ServiceType {
    ServiceType::new(kind, state(), state())
}

type Side = Arc<dyn Middleware>;

/// Two participants. `None` if the backend has no services, after checking that it says so.
fn sides(world: &dyn World) -> Option<(Side, Side)> {
    let (a, b) = (world.join(), world.join());
    if a.capabilities().services {
        return Some((a, b));
    }
    let handler = Arc::new(Adder::default());
    for error in [
        a.serve(&goto(), &service(ServiceKind::Function), handler).err(),
        b.client(&goto(), &service(ServiceKind::Function)).err(),
    ] {
        assert!(matches!(error, Some(OpenError::Unsupported { .. })), "{error:?}");
    }
    None
}

/// Adds 1000 to its input, and answers multiples of 100 with an exception. As an activity it is
/// accepted, enters two states, and then waits to be finished or cancelled.
#[derive(Default)]
struct Adder {
    activity: bool,
    running: Mutex<HashMap<ActivityId, Box<dyn Replies>>>,
}

impl Adder {
    fn activity() -> Self {
        Self { activity: true, ..Self::default() }
    }

    fn outcome(n: u64) -> Outcome {
        if n.is_multiple_of(100) {
            let detail = json!({"distance": 1.5, "why": "trop loin"});
            return Outcome::Exception { name: "::demo::TOO_FAR_AWAY".to_owned(), detail };
        }
        Outcome::Success(numbered(n + 1000))
    }

    fn finish(&self, id: ActivityId) {
        let found = self.running.lock().unwrap().remove(&id);
        if let Some(replies) = found {
            replies.finish(Self::outcome(id.0));
        }
    }
}

impl ServiceHandler for Adder {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        let n = number(&input);
        if !self.activity {
            return replies.finish(Self::outcome(n));
        }
        let id = ActivityId(n);
        // Locked before the caller knows of the activity, so that whoever finishes it finds it in
        // the list.
        let mut running = self.running.lock().unwrap();
        replies.accepted(id);
        replies.feedback("::demo::start");
        replies.feedback("::demo::main");
        running.insert(id, replies);
    }

    fn cancel(&self, id: ActivityId) {
        let found = self.running.lock().unwrap().remove(&id);
        if let Some(replies) = found {
            replies.finish(Outcome::Exception {
                name: "::genom::interrupted".to_owned(),
                detail: Value::Null,
            });
        }
    }
}

/// Calls until somebody answers, since the service may not be visible yet.
#[track_caller]
fn answered(client: &mut dyn Client, n: u64) -> Outcome {
    let mut outcome = None;
    eventually("the service answers", || match client.call(&numbered(n), PATIENCE) {
        Ok(answer) => {
            outcome = Some(answer);
            true
        }
        // `Gone`: the call reached a server that left earlier, before that was known here.
        Err(CallError::Nobody { .. } | CallError::Timeout(_) | CallError::Gone) => false,
        Err(other) => panic!("{other}"),
    });
    outcome.expect("an outcome")
}

#[track_caller]
fn success(outcome: Outcome) -> u64 {
    match outcome {
        Outcome::Success(output) => number(&output),
        other => panic!("no success: {other:?}"),
    }
}

/// A request gets its reply.
pub fn a_function_replies(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    for kind in [ServiceKind::Attribute, ServiceKind::Function] {
        let _served = a.serve(&goto(), &service(kind), Arc::new(Adder::default())).unwrap();
        let mut client = b.client(&goto(), &service(kind)).unwrap();
        for n in 1..20 {
            assert_eq!(success(answered(&mut *client, n)), n + 1000);
        }
    }
}

/// The caller gets the name and the members of the exception.
pub fn an_exception_comes_back_with_its_detail(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let function = service(ServiceKind::Function);
    let _served = a.serve(&goto(), &function, Arc::new(Adder::default())).unwrap();
    let mut client = b.client(&goto(), &function).unwrap();
    let Outcome::Exception { name, detail } = answered(&mut *client, 100) else {
        panic!("no exception")
    };
    assert_eq!(name, "::demo::TOO_FAR_AWAY");
    assert_eq!(detail, json!({"distance": 1.5, "why": "trop loin"}));
    assert_eq!(success(answered(&mut *client, 3)), 1003);
}

/// Starts activity `n`, and retries until it is accepted.
#[track_caller]
fn start(client: &mut dyn Client, n: u64) -> (Box<dyn Running>, ReplyReceiver) {
    let mut started = None;
    eventually("the activity is accepted", || {
        let (replies, reply) = pair();
        match client.request(&numbered(n), Box::new(replies)) {
            Ok(running) => match reply.next(PATIENCE) {
                Ok(Reply::Accepted(_)) => {
                    started = Some((running, reply));
                    true
                }
                Ok(Reply::Finished(Outcome::Lost(CallError::Nobody { .. }))) => false,
                other => panic!("not accepted first: {other:?}"),
            },
            Err(CallError::Nobody { .. }) => false,
            Err(other) => panic!("{other}"),
        }
    });
    started.expect("a running activity")
}

#[track_caller]
fn next_state(reply: &ReplyReceiver) -> String {
    match reply.next(PATIENCE) {
        Ok(Reply::Feedback(state)) => state,
        other => panic!("no state: {other:?}"),
    }
}

/// The caller gets the acceptance, each state in order, and the result.
pub fn an_activity_tells_its_states_and_its_end(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let (activity, handler) = (service(ServiceKind::Activity), Arc::new(Adder::activity()));
    let _served = a.serve(&goto(), &activity, handler.clone()).unwrap();
    let mut client = b.client(&goto(), &activity).unwrap();
    for n in [7, 8, 9] {
        let (_running, reply) = start(&mut *client, n);
        assert_eq!(next_state(&reply), "::demo::start");
        assert_eq!(next_state(&reply), "::demo::main");
        handler.finish(ActivityId(n));
        assert_eq!(success(reply.wait(PATIENCE).unwrap()), n + 1000);
    }
}

/// A cancelled activity still ends through its replies.
pub fn an_activity_is_cancelled_by_its_caller(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let (activity, handler) = (service(ServiceKind::Activity), Arc::new(Adder::activity()));
    let _served = a.serve(&goto(), &activity, handler.clone()).unwrap();
    let mut client = b.client(&goto(), &activity).unwrap();
    let (cancelled, first) = start(&mut *client, 1);
    let (_kept, second) = start(&mut *client, 2);
    // Both have entered the states that come before the wait.
    for reply in [&first, &second] {
        next_state(reply);
        next_state(reply);
    }
    cancelled.cancel();
    match first.wait(PATIENCE) {
        Ok(Outcome::Exception { name, .. }) => assert_eq!(name, "::genom::interrupted"),
        other => panic!("not interrupted: {other:?}"),
    }
    handler.finish(ActivityId(2));
    assert_eq!(success(second.wait(PATIENCE).unwrap()), 1002);
    cancelled.cancel();
}

/// Each caller gets its own reply.
pub fn requests_overlap_and_are_answered_apart(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let (activity, handler) = (service(ServiceKind::Activity), Arc::new(Adder::activity()));
    let _served = a.serve(&goto(), &activity, handler.clone()).unwrap();
    let mut clients = [&a, &b].map(|side| side.client(&goto(), &activity).unwrap());
    let under_way: Vec<_> =
        (1..9).map(|n| (n, start(&mut *clients[n as usize % 2], n).1)).collect();
    for n in (1..9).rev() {
        handler.finish(ActivityId(n));
    }
    for (n, reply) in under_way {
        assert_eq!(success(reply.wait(PATIENCE).unwrap()), n + 1000);
    }
}

/// A call without a server fails at once, and does not hang.
pub fn a_call_to_nobody_says_so(world: &dyn World) {
    let Some((_, b)) = sides(world) else { return };
    let mut client = b.client(&goto(), &service(ServiceKind::Function)).unwrap();
    match client.call(&numbered(1), Duration::from_millis(200)) {
        Err(CallError::Nobody { .. } | CallError::Timeout(_)) => {}
        other => panic!("somebody answered: {other:?}"),
    }
}

/// Caller and service may be opened in either order, and a service may come back.
pub fn a_service_may_come_after_its_caller(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let function = service(ServiceKind::Function);
    let mut client = b.client(&goto(), &function).unwrap();
    for n in 1..5 {
        let served = a.serve(&goto(), &function, Arc::new(Adder::default())).unwrap();
        assert_eq!(success(answered(&mut *client, n)), n + 1000);
        drop(served);
    }
}

/// A caller does not wait for a service that is gone.
pub fn a_service_that_leaves_tells_its_caller(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let activity = service(ServiceKind::Activity);
    let served = a.serve(&goto(), &activity, Arc::new(Adder::activity())).unwrap();
    let mut client = b.client(&goto(), &activity).unwrap();
    let (_running, reply) = start(&mut *client, 1);
    drop(served);
    match reply.wait(PATIENCE) {
        Err(CallError::Gone) => {}
        other => panic!("no word of it: {other:?}"),
    }
}

/// An address has one server.
pub fn a_second_server_of_an_address_is_refused(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let function = service(ServiceKind::Function);
    let _served = a.serve(&goto(), &function, Arc::new(Adder::default())).unwrap();
    eventually("the second server is refused", || {
        match b.serve(&goto(), &function, Arc::new(Adder::default())) {
            Err(OpenError::Taken { address }) => address == goto(),
            Err(other) => panic!("refused for another reason: {other}"),
            Ok(_) => false,
        }
    });
}

/// Input, output and declared exceptions must be the server's.
pub fn a_service_of_other_types_is_refused(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    let function = service(ServiceKind::Function);
    let _served = a.serve(&goto(), &function, Arc::new(Adder::default())).unwrap();
    for other in [
        ServiceType::new(ServiceKind::Function, note(), state()),
        ServiceType::new(ServiceKind::Function, state(), note()),
        ServiceType::new(ServiceKind::Function, other_state(), state()),
        function.clone().described("feed"),
    ] {
        eventually("the other types are refused", || match b.client(&goto(), &other) {
            Err(OpenError::TypeMismatch { ours, theirs, .. }) => ours != theirs,
            Err(error) => panic!("refused for another reason: {error}"),
            Ok(mut client) => {
                let called = client.call(&Record::new(&other.input), PATIENCE);
                matches!(called, Err(CallError::TypeMismatch { .. }))
            }
        });
    }
}

/// Services are visible while they are served, and leave nothing behind.
pub fn services_show_while_they_are_served(world: &dyn World) {
    let Some((a, b)) = sides(world) else { return };
    if a.discovery().is_none() {
        return;
    }
    let function = service(ServiceKind::Function);
    let shows = || {
        let seen = b.discover().expect("a list");
        seen.iter()
            .any(|end| end.kind == EndpointKind::Service && end.address == goto().to_string())
    };
    // Listing a single address gives the same result; on a network, one that is only just seen may
    // be missing for a moment, until it is known who it belongs to.
    let kinds = || -> Vec<EndpointKind> {
        b.ends_at(&goto()).expect("a list").iter().map(|end| end.kind).collect()
    };
    let mut client = b.client(&goto(), &function).unwrap();
    assert!(!shows(), "a caller is no service");
    assert_eq!(kinds(), []);
    let served = a.serve(&goto(), &function, Arc::new(Adder::default())).unwrap();
    eventually("the service shows", shows);
    eventually("it shows at its address", || kinds() == [EndpointKind::Service]);
    assert_eq!(success(answered(&mut *client, 5)), 1005);
    drop(served);
    eventually("the service is gone", || !shows() && kinds().is_empty());
    drop((client, a, b));
    assert_eq!(world.leftovers(), Vec::<String>::new());
}

/// A service whose handler has an out port of its own: nothing waits for itself when both are closed,
/// and the addresses are free again.
pub fn what_a_handler_holds_is_closed_with_its_service(world: &dyn World) {
    struct Holder(
        #[expect(dead_code, reason = "closed when it is dropped")] Mutex<Box<dyn Publisher>>,
    );

    impl ServiceHandler for Holder {
        fn request(&self, input: Record, replies: Box<dyn Replies>) {
            replies.finish(Outcome::Success(input));
        }

        fn cancel(&self, _: ActivityId) {}
    }

    let Some((a, b)) = sides(world) else { return };
    let (ty, function) = (state(), service(ServiceKind::Function));
    let address = Address::new("demo", "position");
    // The handler may still return to whoever called it when its service is closed.
    for _ in 0..10 {
        let publisher = a.publisher(&PortSpec::new(&address, &ty)).unwrap();
        let handler = Arc::new(Holder(Mutex::new(publisher)));
        let served = a.serve(&goto(), &function, handler).unwrap();
        let mut client = b.client(&goto(), &function).unwrap();
        assert_eq!(success(answered(&mut *client, 5)), 5);
        drop((client, served));
    }
    drop((a, b));
    assert_eq!(world.leftovers(), Vec::<String>::new());
}
