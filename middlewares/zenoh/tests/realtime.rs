//! What real-time threads feel of zenoh: nothing.

mod world;

use genom_allocations as allocations;
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, set_number, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_types::Record;
use world::Meeting;

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers = policies
        .map(|policy| b.subscription(&PortSpec::new(&position(), &state()), policy).unwrap());
    let (mut sent, mut got) = (numbered(0), Record::new(&state()));
    let mut counted = 0;
    for n in 1..200 {
        set_number(&mut sent, n);
        let before = allocations::count();
        writer.publish(&sent).unwrap();
        counted += allocations::count() - before;
        for reader in &mut readers {
            eventually("the sample arrives", || {
                let before = allocations::count();
                let reading = reader.read(&mut got).unwrap();
                counted += allocations::count() - before;
                reading == Reading::New && number(&got) == n
            });
        }
        // The first round makes what the thread itself needs.
        if n == 1 {
            counted = 0;
        }
    }
    assert_eq!(counted, 0);
}

#[test]
fn a_stalled_network_holds_up_no_writer_and_the_newest_sample_arrives() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let mut reader =
        b.subscription(&PortSpec::new(&position(), &state()), Policy::Ring(64)).unwrap();
    let mut got = Record::new(&state());
    writer.publish(&numbered(1)).unwrap();
    eventually("they are connected", || reader.read(&mut got).unwrap() == Reading::New);

    let stalled = a.stall();
    // Returns although nothing is sent: else the test hangs here.
    for n in 2..=1000 {
        writer.publish(&numbered(n)).unwrap();
    }
    let kept = 999 - writer.dropped();
    assert!((1..100).contains(&kept), "{kept} samples wait");
    assert_eq!(reader.read(&mut got), Ok(Reading::Same));
    drop(stalled);
    let mut read = Vec::new();
    eventually("the newest arrives", || {
        if reader.read(&mut got).unwrap() == Reading::New {
            read.push(number(&got));
        }
        read.last() == Some(&1000)
    });
    assert_eq!(read.len() as u64, kept, "what was not dropped arrived");
}
