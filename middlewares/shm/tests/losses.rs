//! Samples published after a reader was opened and lost before its first read are counted.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail them")]

mod world;

use genom_conformance::eventually;
use genom_conformance::samples::{numbered, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Publisher, Reading, Subscription};
use genom_shm::Shm;
use genom_types::Record;

use world::ShmWorld;

const POLICIES: [Policy; 2] = [Policy::Ring(4), Policy::Queue(4)];

fn position() -> Address {
    Address::new("demo", "position")
}

fn writer(on: &Shm) -> Box<dyn Publisher> {
    on.publisher(&PortSpec::new(&position(), &state())).unwrap()
}

fn reader(on: &Shm, policy: Policy) -> Box<dyn Subscription> {
    on.subscription(&PortSpec::new(&position(), &state()), policy).unwrap()
}

fn burst(writer: &mut dyn Publisher, from: u64, to: u64) {
    (from..=to).for_each(|n| writer.publish(&numbered(n)).unwrap());
}

/// Reads everything there is: samples read and samples counted as lost add up to those written.
#[track_caller]
fn adds_up(reader: &mut dyn Subscription, written: u64) {
    let (mut got, mut seen) = (Record::new(&state()), 0);
    eventually("the samples are read or counted", || {
        seen += u64::from(reader.read(&mut got).unwrap() == Reading::New);
        seen + reader.dropped() == written
    });
    assert_eq!(reader.read(&mut got), Ok(Reading::Same));
    assert_eq!(seen + reader.dropped(), written);
}

#[test]
fn a_burst_before_the_first_read_is_read_or_counted() {
    for policy in POLICIES {
        let world = ShmWorld::new();
        let shm = world.open();
        // Opened before the writer, after it, and after another reader.
        let mut early = reader(&shm, policy);
        let mut writer = writer(&shm);
        let mut second = reader(&shm, policy);
        let mut third = reader(&shm, policy);
        burst(&mut *writer, 1, 50);
        for reader in [&mut early, &mut second, &mut third] {
            adds_up(&mut **reader, 50);
        }
    }
}

#[test]
fn a_burst_before_the_first_read_of_a_late_reader_is_counted_from_the_value_it_started_with() {
    for policy in POLICIES {
        let world = ShmWorld::new();
        let (shm, other) = (world.open(), world.open());
        let mut writer = writer(&shm);
        burst(&mut *writer, 1, 20);
        let mut first = reader(&shm, policy);
        burst(&mut *writer, 21, 30);
        // In another daemon. The publisher exists already, because of the first reader.
        let mut late = reader(&other, policy);
        burst(&mut *writer, 31, 60);
        adds_up(&mut *late, 31);
        adds_up(&mut *first, 41);
    }
}

/// As many readers are there before as after: their number alone would not tell.
#[test]
fn a_reader_that_takes_the_place_of_another_one_gets_the_value_of_an_idle_writer() {
    for policy in [Policy::Latest, Policy::Ring(4), Policy::Queue(4)] {
        let world = ShmWorld::new();
        let (shm, other) = (world.open(), world.open());
        let mut writer = writer(&shm);
        burst(&mut *writer, 1, 20);
        let mut got = Record::new(&state());
        let mut before = reader(&other, policy);
        for _ in 0..8 {
            eventually("the last value", || before.read(&mut got) == Ok(Reading::New));
            assert!(got.holds_same(&numbered(20)));
            drop(before);
            before = reader(&other, policy);
        }
    }
}

#[test]
fn a_writer_that_comes_back_is_counted_from_its_first_sample() {
    for policy in POLICIES {
        let world = ShmWorld::new();
        let shm = world.open();
        let mut reader = reader(&shm, policy);
        let mut first = writer(&shm);
        burst(&mut *first, 1, 1);
        adds_up(&mut *reader, 1);
        drop(first);
        let mut again = writer(&shm);
        burst(&mut *again, 1, 30);
        let dropped = reader.dropped();
        let mut got = Record::new(&state());
        let mut seen = 0;
        while reader.read(&mut got).unwrap() == Reading::New {
            seen += 1;
        }
        assert_eq!(seen + reader.dropped() - dropped, 30);
    }
}
