//! A foreign DDS peer reads and writes ports as a ROS 2 node would.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

mod world;

use std::sync::Arc;

use genom_components::peer::Lines;
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, small, state};
use genom_middleware::{
    ActivityId, Address, Discovery, EndpointKind, Outcome, Policy, PortSpec, Ports, ReadError,
    Reading, Replies, ServiceHandler, ServiceKind, ServiceType, Services,
};
use genom_ros2::ServiceMapping;
use genom_types::Record;
use serde_json::json;
use world::Domain;

/// Starts `peer.py` in a domain.
fn start(domain: &Domain, what: &str) -> Lines {
    domain.peer(&[what])
}

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn a_dds_peer_reads_a_port_though_it_comes_late() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut writer = ros2.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(41)).unwrap();
    let peer = start(&domain, "read");
    peer.says("sample 41");
    for n in 42..60 {
        writer.publish(&numbered(n)).unwrap();
        peer.says(&format!("sample {n}"));
    }
}

#[test]
fn a_dds_peer_writes_a_port_and_what_it_breaks_is_counted() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut reader =
        ros2.subscription(&PortSpec::new(&position(), &state()), Policy::Queue(8)).unwrap();
    let mut peer = start(&domain, "write");
    let mut got = Record::new(&state());
    for n in 5..9 {
        peer.tell(&format!("put {n}"));
        peer.says("done");
        eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
        assert_eq!(number(&got), n);
    }
    let seen = ros2.discover().unwrap();
    let shows = seen.iter().any(|end| {
        end.kind == EndpointKind::Publisher
            && (end.address.as_str(), end.ty.as_str()) == ("demo/position", "demo/msg/State")
    });
    assert!(shows, "the peer's topic is listed: {seen:?}");
    assert_eq!(reader.dropped(), 0);
    peer.tell("short 7");
    peer.says("done");
    eventually("the bad sample is refused", || {
        reader.read(&mut got) == Err(ReadError::Serialization)
    });
    assert_eq!(number(&got), 8, "the value read before is kept");
    assert_eq!(reader.dropped(), 1);
}

/// Adds 1000, and refuses 13.
struct Adder;

impl ServiceHandler for Adder {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        replies.finish(match number(&input) {
            13 => Outcome::Exception {
                name: "::demo::TOO_FAR_AWAY".to_owned(),
                detail: json!({"why": "trop loin"}),
            },
            n => Outcome::Success(numbered(n + 1000)),
        });
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
fn a_dds_peer_calls_a_service_as_rmw_cyclonedds_does() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let ty = ServiceType::new(ServiceKind::Function, state(), state());
    let at = Address::new("demo", "goto");
    let _served = ros2.serve(&at, &ty, Arc::new(Adder)).unwrap();
    let mut peer = start(&domain, "call");
    for n in [1, 2, 40] {
        peer.tell(&n.to_string());
        peer.says(&format!("reply {}", n + 1000));
    }
    peer.tell("13");
    peer.says("::demo::TOO_FAR_AWAY {\"why\":\"trop loin\"}");
}

#[test]
fn types_of_less_than_a_word_come_back_from_a_dds_peer_as_they_were_sent() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let ros2 = domain.open();
    let mut ends = small().map(|(ty, values)| {
        let name = ty.name().trim_start_matches("::demo::").to_owned();
        let at = |instance| Address::new(instance, &name);
        let writer = ros2.publisher(&PortSpec::new(&at("demo"), &ty)).unwrap();
        let reader =
            ros2.subscription(&PortSpec::new(&at("mirror"), &ty), Policy::Queue(8)).unwrap();
        (ty, values, writer, reader)
    });
    let _peer = start(&domain, "mirror");
    for (ty, values, writer, reader) in &mut ends {
        let (mut sent, mut got) = (Record::new(ty), Record::new(ty));
        for value in values.as_array().unwrap() {
            sent.merge_json(&json!({ "it": value })).unwrap();
            writer.publish(&sent).unwrap();
            // The first may arrive twice: when it is written, and as the last value for a late
            // reader.
            eventually(&format!("{} {value} comes back", ty.name()), || {
                reader.read(&mut got).unwrap() == Reading::New && got.to_json() == sent.to_json()
            });
        }
        assert_eq!(reader.dropped(), 0, "{}", ty.name());
    }
}
