//! One daemon with both ends of a port.

#![allow(clippy::expect_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use genom_middleware::conformance::{World, eventually, samples};
use genom_middleware::{Address, Policy, Reading};
use world::Domain;

#[test]
fn both_ends_of_a_port_may_be_in_one_daemon() {
    let world = Domain::new();
    let alone = world.join();
    let (at, ty) = (Address::new("demo", "position"), samples::state());
    let mut reader = alone.subscription(&at, &ty, Policy::Latest).unwrap();
    let mut writer = alone.publisher(&at, &ty).unwrap();
    let mut late = None;
    for n in 1..20 {
        writer.publish(&samples::numbered(n)).unwrap();
        let mut got = samples::numbered(0);
        eventually(&format!("sample {n} arrives"), || {
            reader.read(&mut got).unwrap() == Reading::New
        });
        assert_eq!(samples::number(&got), n);
        let late =
            late.get_or_insert_with(|| alone.subscription(&at, &ty, Policy::Ring(4)).unwrap());
        eventually("a late reader has it too", || late.read(&mut got).unwrap() == Reading::New);
        assert_eq!(samples::number(&got), n);
        assert_eq!(late.read(&mut got).unwrap(), Reading::Same);
    }
}
