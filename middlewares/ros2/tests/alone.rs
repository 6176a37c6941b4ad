//! One daemon with both ends of a port or a service.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

mod world;
#[path = "world/zenoh.rs"]
mod zenoh_world;

use genom_conformance::{World, eventually, samples};
use std::sync::Arc;
use std::time::Duration;

use genom_middleware::{
    ActivityId, Address, Outcome, Policy, PortSpec, Reading, Replies, ServiceHandler, ServiceKind,
    ServiceType,
};
use genom_ros2::ServiceMapping;
use genom_types::Record;
use world::Domain;
use zenoh_world::Place;

#[test]
fn both_ends_of_a_port_may_be_in_one_daemon() {
    both_ends_of_a_port(&Domain::new(ServiceMapping::Cyclone));
}

#[test]
fn both_ends_of_a_port_may_be_in_one_daemon_over_zenoh() {
    both_ends_of_a_port(&Place::new());
}

fn both_ends_of_a_port(world: &dyn World) {
    let alone = world.join();
    let (at, ty) = (Address::new("demo", "position"), samples::state());
    let mut reader = alone.subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap();
    let mut writer = alone.publisher(&PortSpec::new(&at, &ty)).unwrap();
    let mut late = None;
    for n in 1..20 {
        writer.publish(&samples::numbered(n)).unwrap();
        let mut got = samples::numbered(0);
        eventually(&format!("sample {n} arrives"), || {
            reader.read(&mut got).unwrap() == Reading::New
        });
        assert_eq!(samples::number(&got), n);
        let late = late.get_or_insert_with(|| {
            alone.subscription(&PortSpec::new(&at, &ty), Policy::Ring(4)).unwrap()
        });
        eventually("a late reader has it too", || late.read(&mut got).unwrap() == Reading::New);
        assert_eq!(samples::number(&got), n);
        assert_eq!(late.read(&mut got).unwrap(), Reading::Same);
    }
}

/// Returns its input.
struct Echo;

impl ServiceHandler for Echo {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        replies.finish(Outcome::Success(input));
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
fn both_ends_of_a_service_may_be_in_one_daemon() {
    let world = Domain::new(ServiceMapping::Enhanced);
    let alone = world.join();
    let (at, state) = (Address::new("demo", "goto"), samples::state());
    let ty = ServiceType::new(ServiceKind::Function, state.clone(), state);
    let _served = alone.serve(&at, &ty, Arc::new(Echo)).unwrap();
    let mut client = alone.client(&at, &ty).unwrap();
    for n in 1..4 {
        match client.call(&samples::numbered(n), Duration::from_secs(30)) {
            Ok(Outcome::Success(output)) => assert_eq!(samples::number(&output), n),
            other => panic!("no echo: {other:?}"),
        }
    }
}
