//! YARP does not affect real-time threads.

mod world;

use genom_allocations as allocations;
use genom_conformance::ports::grown_in_ticks;
use genom_conformance::samples::state;
use genom_middleware::{Address, Policy, PortSpec, Ports};
use world::Place;

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let place = Place::new();
    let (a, b) = (place.open(), place.open());
    let (at, ty) = (Address::new("demo", "position"), state());
    let port = PortSpec::new(&at, &ty);
    let mut writer = a.publisher(&port).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers = policies.map(|policy| b.subscription(&port, policy).unwrap());
    assert_eq!(grown_in_ticks(&mut *writer, &mut readers, allocations::count), 0);
}
