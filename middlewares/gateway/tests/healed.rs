//! A gateway ends, and another one takes its place: what was open is open again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_conformance::eventually;
use genom_conformance::ports::{position, read_until, reader, writer};
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::reply::{Reply, pair};
use genom_middleware::{
    ActivityId, Address, CallError, EndpointKind, Middleware, Outcome, Policy, Reading, Replies,
    ServiceHandler, ServiceKind, ServiceType,
};
use genom_types::Record;
use world::{House, Kind};

const PATIENCE: Duration = Duration::from_secs(30);

/// Answers with its input; an activity waits for ever, and is kept.
#[derive(Default)]
struct Echo {
    kept: Mutex<Vec<Box<dyn Replies>>>,
}

impl ServiceHandler for Echo {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        if number(&input) == 0 {
            replies.accepted(ActivityId(1));
            return self.kept.lock().unwrap().push(replies);
        }
        replies.finish(Outcome::Success(input));
    }

    fn cancel(&self, _: ActivityId) {}
}

fn goto() -> Address {
    Address::new("demo", "goto")
}

fn echo() -> ServiceType {
    ServiceType::new(ServiceKind::Activity, state(), state())
}

fn calls(on: &Arc<dyn Middleware>, n: u64) {
    let mut client = on.client(&goto(), &echo()).unwrap();
    eventually("the service answers", || match client.call(&numbered(n), PATIENCE) {
        Ok(Outcome::Success(output)) => number(&output) == n,
        Ok(other) => panic!("{other:?}"),
        Err(_) => false,
    });
}

fn is_healed(kind: Kind) {
    let house = House::new(kind, false);
    let (other, mut gateway) = (house.direct(), house.gateway(0));
    let proxy = house.proxy(0);
    // A writer and a reader behind the gateway, and their peers outside.
    let mut out = writer(&proxy);
    let mut seen = reader(&other, Policy::Latest);
    let back = Address::new("demo", "parameter");
    let port = |on: &Arc<dyn Middleware>| {
        on.publisher(&genom_middleware::PortSpec::new(&back, &state())).unwrap()
    };
    let mut outside = port(&other);
    let mut inside = proxy
        .subscription(&genom_middleware::PortSpec::new(&back, &state()), Policy::Latest)
        .unwrap();
    let handler = Arc::<Echo>::default();
    let _served = proxy.serve(&goto(), &echo(), handler).unwrap();
    for round in 1..4 {
        out.publish(&numbered(round)).unwrap();
        read_until(&mut *seen, round);
        outside.publish(&numbered(100 + round)).unwrap();
        read_until(&mut *inside, 100 + round);
        calls(&other, round);
        drop(gateway);
        // Nobody waits for it: the writer goes on, the reader keeps what it has.
        out.publish(&numbered(1000 * round)).unwrap();
        let mut kept = numbered(0);
        assert_eq!(inside.read(&mut kept).unwrap(), Reading::Same);
        gateway = house.gateway(0);
        read_until(&mut *seen, 1000 * round);
    }
    // The last value was published again, for readers that come only now.
    let mut late = reader(&other, Policy::Latest);
    read_until(&mut *late, 3000);
    calls(&other, 77);
    assert_eq!(inside.dropped(), 0);
    drop(gateway);
}

#[test]
fn what_is_open_on_zenoh_is_open_again_in_the_next_gateway() {
    is_healed(Kind::Zenoh);
}

#[test]
fn what_is_open_on_ros2_is_open_again_in_the_next_gateway() {
    is_healed(Kind::Ros2);
}

#[test]
fn requests_under_way_end_with_their_gateway_and_the_next_ones_do_not() {
    let house = House::new(Kind::Zenoh, false);
    let (other, gateway) = (house.direct(), house.gateway(0));
    let proxy = house.proxy(0);
    let handler = Arc::<Echo>::default();
    let _served = other.serve(&goto(), &echo(), handler).unwrap();
    calls(&proxy, 5);
    let mut client = proxy.client(&goto(), &echo()).unwrap();
    let (replies, answer) = pair();
    let running = client.request(&numbered(0), Box::new(replies)).unwrap();
    assert!(matches!(answer.next(PATIENCE), Ok(Reply::Accepted(ActivityId(1)))));
    drop(gateway);
    match answer.wait(PATIENCE) {
        Err(CallError::Failed { backend, why }) => {
            assert_eq!(backend, "zenoh");
            assert!(why.contains("ended while the request was under way"), "{why}");
        }
        other => panic!("no word of it: {other:?}"),
    }
    running.cancel();
    // One that is made meanwhile is told at once why it fails.
    let refused = client.call(&numbered(6), PATIENCE).unwrap_err().to_string();
    assert!(refused.contains("its gateway does not answer"), "{refused}");
    let _gateway = house.gateway(0);
    eventually("the same client gets answers", || {
        matches!(client.call(&numbered(7), PATIENCE), Ok(Outcome::Success(_)))
    });
}

#[test]
fn a_daemon_is_reachable_again_through_the_next_gateway() {
    let house = House::new(Kind::Zenoh, false);
    let (other, gateway) = (house.direct(), house.gateway(0));
    let proxy = house.proxy(0);
    let announced = proxy.relay().unwrap().announce(
        "robot",
        Box::new(|message, answer| {
            // Of the others, there is no reply.
            if message == b"ping" {
                answer(b"pong".to_vec());
            }
        }),
    );
    let announced = announced.unwrap();
    let answers = |message: &[u8]| {
        let relay = other.relay().unwrap();
        relay.ask_all("robot", message, Duration::from_secs(5))
    };
    let first = answers(b"ping").unwrap();
    assert_eq!(first, [(proxy.relay().unwrap().own(), b"pong".to_vec())]);
    assert!(answers(b"other").is_ok_and(|all| all.is_empty()) || answers(b"other").is_err());
    drop(gateway);
    let _gateway = house.gateway(0);
    eventually("it answers again", || {
        answers(b"ping").is_ok_and(|all| all.len() == 1 && all[0].1 == b"pong")
    });
    drop(announced);
    eventually("it is withdrawn", || other.relay().unwrap().daemons().unwrap().is_empty());
}

#[test]
fn who_looks_for_a_fault_is_told_that_the_gateway_is_down() {
    let house = House::new(Kind::Ros2, false);
    let gateway = house.gateway(0);
    let proxy = house.proxy(0);
    let _out = writer(&proxy);
    let shown = proxy.ends_at(&position()).unwrap();
    assert_eq!(shown.iter().map(|end| end.kind).collect::<Vec<_>>(), [EndpointKind::Publisher]);
    assert_eq!(proxy.obstacles(&position()), []);
    drop(gateway);
    let obstacles = proxy.obstacles(&position());
    assert!(obstacles[0].what.starts_with("the gateway of ros2 is down"), "{obstacles:?}");
    assert!(obstacles[0].fix.contains("genomctl cells --restart gateway-ros2"));
    assert!(proxy.discover().unwrap_err().why.contains("its gateway does not answer"));
    // What it is does not depend on whether its gateway runs.
    assert!(proxy.capabilities().services && proxy.services().is_some());
}
