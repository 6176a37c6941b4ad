//! Quality of service of single ports, tested with a foreign DDS peer.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use genom_components::peer::Lines;
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{
    Address, Discovery, Obstacle, Policy, PortSpec, Ports, Publisher, Quality, Reading,
    Subscription,
};
use genom_ros2::{Ros2, ServiceMapping};
use genom_types::Record;
use world::Domain;

const RELIABLE: Quality = Quality { reliable: Some(true), depth: None, transient_local: None };
const BEST_EFFORT: Quality = Quality { reliable: Some(false), depth: None, transient_local: None };
const LATCHED: Quality = Quality { reliable: None, depth: None, transient_local: Some(true) };

fn position() -> Address {
    Address::new("demo", "position")
}

fn reader(ros2: &Ros2, quality: &Quality) -> Box<dyn Subscription> {
    ros2.subscription(&PortSpec::new(&position(), &state()).of(*quality), Policy::Ring(64)).unwrap()
}

fn writer(ros2: &Ros2, quality: &Quality) -> Box<dyn Publisher> {
    ros2.publisher(&PortSpec::new(&position(), &state()).of(*quality)).unwrap()
}

/// The next sample, if there is one.
fn next(reader: &mut dyn Subscription) -> Option<u64> {
    let mut got = Record::new(&state());
    (reader.read(&mut got).unwrap() == Reading::New).then(|| number(&got))
}

/// Makes the peer write until this reader gets a sample, since best effort may lose some.
fn hears(reader: &mut dyn Subscription, peer: &mut Lines, n: &mut u64) {
    eventually("a sample of the peer arrives", || {
        *n += 1;
        peer.tell(&format!("put {n}"));
        peer.says("done");
        next(reader).is_some()
    });
}

/// The first obstacle that is reported.
fn obstacle(ros2: &Ros2) -> Obstacle {
    let mut all = Vec::new();
    eventually("it is told what does not fit", || {
        all = ros2.obstacles(&position());
        !all.is_empty()
    });
    assert_eq!(all.len(), 1, "{all:?}");
    all.remove(0)
}

#[test]
fn an_in_port_follows_a_writer_that_offers_best_effort() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut early = reader(&ros2, &Quality::default());
    let mut peer = domain.peer(&["write", "best_effort"]);
    let mut n = 0;
    hears(&mut *early, &mut peer, &mut n);
    assert_eq!(ros2.obstacles(&position()), []);
    // The writer is known by now, so the reader requests its QoS at once.
    let mut late = reader(&domain.open(), &Quality::default());
    hears(&mut *late, &mut peer, &mut n);
    // From then on no sample arrives twice or out of order.
    let mut last = 0;
    while let Some(n) = next(&mut *early) {
        assert!(n > last, "{n} after {last}");
        last = n;
    }
}

#[test]
fn an_in_port_between_reliable_and_best_effort_writers_is_told_what_it_does_without() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let _reader = reader(&ros2, &Quality::default());
    // From now on both have a writer.
    let peers = [domain.peer(&["write", "best_effort"]), domain.peer(&["write"])];
    let _peers = peers.map(|mut peer| {
        peer.tell("early 1");
        peer.says("done");
        peer
    });
    let told = "some writers of demo/position on ros2 offer reliable, others best effort";
    eventually("it is told", || {
        ros2.obstacles(&position()).iter().any(|one| one.what.starts_with(told))
    });
}

#[test]
fn an_in_port_gets_what_a_transient_local_writer_wrote_before() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let mut peer = domain.peer(&["write", "transient_local"]);
    peer.tell("early 7");
    peer.says("done");
    let ros2 = domain.open();
    let mut reader = reader(&ros2, &Quality::default());
    eventually("the map arrives", || next(&mut *reader) == Some(7));
    peer.tell("early 8");
    peer.says("done");
    eventually("the next one arrives", || next(&mut *reader) == Some(8));
}

#[test]
fn an_in_port_that_insists_is_told_of_writers_that_offer_less() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut strict = reader(&ros2, &RELIABLE);
    let mut peer = domain.peer(&["write", "best_effort"]);
    peer.tell("early 1");
    peer.says("done");
    let told = obstacle(&ros2);
    assert_eq!(
        told.what,
        "a writer of demo/position on ros2 offers best effort, and the in port asks for reliable"
    );
    assert!(told.fix.contains("`reliable = false`"), "{told:?}");
    // Another in port of the same daemon accepts any QoS.
    let mut free = reader(&ros2, &Quality::default());
    hears(&mut *free, &mut peer, &mut 0);
    assert_eq!(next(&mut *strict), None);
}

#[test]
fn an_out_port_of_best_effort_tells_of_a_reader_that_asks_for_more() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut writer = writer(&ros2, &BEST_EFFORT);
    let _reader = domain.peer(&["read"]);
    let told = obstacle(&ros2);
    assert_eq!(
        told.what,
        "a reader of demo/position on ros2 asks for reliable, and the port offers best effort"
    );
    assert!(told.fix.contains("`reliable = true`"), "{told:?}");
    let other = domain.peer(&["read", "best_effort"]);
    let mut n = 0;
    eventually("one that asks for as much hears it", || {
        n += 1;
        writer.publish(&numbered(n)).unwrap();
        other.heard().is_some()
    });
}

#[test]
fn an_out_port_serves_late_readers_that_ask_for_transient_local_if_it_is_told_to() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let first = writer(&ros2, &Quality::default());
    let peer = domain.peer(&["read", "transient_local"]);
    let told = obstacle(&ros2);
    assert!(told.what.ends_with("asks for transient local, and the port offers volatile"));
    drop((first, peer));
    let mut second = writer(&ros2, &LATCHED);
    second.publish(&numbered(41)).unwrap();
    let peer = domain.peer(&["read", "transient_local"]);
    peer.says("sample 41");
}
