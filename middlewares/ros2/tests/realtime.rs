//! ROS 2 does not affect real-time threads.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "test code")]

mod world;
#[path = "world/zenoh.rs"]
mod zenoh_world;

use genom_allocations as allocations;
use genom_conformance::eventually;
use genom_conformance::ports::grown_in_ticks;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_ros2::{Ros2, ServiceMapping};
use genom_types::Record;
use world::Domain;
use zenoh_world::Place;

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    allocates_nothing(&domain.open(), &domain.open());
}

#[test]
fn writing_and_reading_over_zenoh_allocates_nothing_either() {
    let place = Place::new();
    allocates_nothing(&place.open(), &place.open());
}

fn allocates_nothing(a: &Ros2, b: &Ros2) {
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let reader = b.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    assert_eq!(grown_in_ticks(&mut *writer, &mut [reader], allocations::count), 0);
}

#[test]
fn a_stalled_network_holds_up_no_writer_and_the_newest_sample_arrives() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    is_not_held_up(&domain.open(), &domain.open());
}

#[test]
fn a_stalled_zenoh_holds_up_no_writer_either() {
    let place = Place::new();
    is_not_held_up(&place.open(), &place.open());
}

fn is_not_held_up(a: &Ros2, b: &Ros2) {
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let mut reader =
        b.subscription(&PortSpec::new(&position(), &state()), Policy::Ring(64)).unwrap();
    let mut got = Record::new(&state());
    writer.publish(&numbered(1)).unwrap();
    eventually("they are connected", || reader.read(&mut got).unwrap() == Reading::New);

    let stalled = a.stall();
    // Returns although nothing is sent; otherwise the test hangs here.
    for n in 2..=1000 {
        writer.publish(&numbered(n)).unwrap();
    }
    assert!(writer.dropped() > 900, "{} samples are given up", writer.dropped());
    drop(stalled);
    eventually("the newest arrives", || {
        reader.read(&mut got).unwrap() == Reading::New && number(&got) == 1000
    });
    assert_eq!(writer.dropped() + 1 + 16, 1000, "as many were kept as may wait");
}
