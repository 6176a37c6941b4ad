//! Real-time threads are not affected by what is between them and a gateway.

#![allow(clippy::unwrap_used, reason = "test code, also outside of test functions")]

mod world;

use genom_allocations as allocations;
use genom_conformance::World as _;
use genom_conformance::ports::grown_in_ticks;
use genom_conformance::samples::state;
use genom_middleware::{Address, Policy, PortSpec};
use world::{House, Kind};

fn ticks_allocate_nothing(kind: Kind) {
    let house = House::new(kind, false);
    let (a, b) = (house.join(), house.join());
    let at = Address::new("demo", "position");
    let mut writer = a.publisher(&PortSpec::new(&at, &state())).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers =
        policies.map(|policy| b.subscription(&PortSpec::new(&at, &state()), policy).unwrap());
    assert_eq!(grown_in_ticks(&mut *writer, &mut readers, allocations::count), 0);
}

#[test]
fn writing_and_reading_through_a_gateway_of_zenoh_allocates_nothing() {
    ticks_allocate_nothing(Kind::Zenoh);
}

#[test]
fn writing_and_reading_through_a_gateway_of_ros2_allocates_nothing() {
    ticks_allocate_nothing(Kind::Ros2);
}
