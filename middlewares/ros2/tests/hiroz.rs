//! The mode `zenoh` together with hiroz, an implementation of ROS 2 over zenoh that is not ours.
//! Hashes are those that ROS 2 Jazzy publishes.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

#[path = "hiroz/acts.rs"]
mod acts;
#[path = "hiroz/described.rs"]
mod described;
#[path = "hiroz/parameters.rs"]
mod parameters;
#[path = "world/services.rs"]
mod services;
#[path = "world/zenoh.rs"]
mod world;

use std::sync::Arc;
use std::time::Duration;

use genom_components::hiroz;
use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_conformance::samples::basic;
use genom_middleware::{
    ActivityId, Address, Discovery, EndpointKind, OpenError, Outcome, Policy, PortSpec, Ports,
    Quality, Reading, Replies, ServiceHandler, Services,
};
use genom_ros2::{Options, Ros2};
use genom_types::{DataType, Kind, Record};
use serde_json::{Value, json};
use services::{count, reset};
use world::Place;

const FLOAT: &str = "std_msgs::msg::dds_::Float64_";
const FLOAT_HASH: &str = "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a";
const TRIGGER: &str = "std_srvs::srv::dds_::Trigger_";
const TRIGGER_HASH: &str =
    "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";

fn node(place: &Place) -> Peer {
    let node = hiroz::node(&place.router());
    Peer::start(&mut node.unwrap_or_else(|error| panic!("hiroz cannot be had: {error}")))
}

fn speed() -> Address {
    Address::new("demo", "speed")
}

fn double() -> DataType {
    basic(Kind::Double)
}

/// A `Float64` in CDR.
fn float(value: f64) -> String {
    let bytes = [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn value(n: f64) -> Record {
    let mut record = Record::new(&double());
    record.set_bytes(&n.to_ne_bytes()).unwrap();
    record
}

fn read_of(record: &Record) -> f64 {
    f64::from_ne_bytes(record.bytes().unwrap().try_into().unwrap())
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_reads_every_sample_of_a_port_in_order() {
    let place = Place::new();
    let ros2 = place.open();
    let mut writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut node = node(&place);
    node.ask(&json!(["read", "/demo/speed", FLOAT, FLOAT_HASH]));
    eventually("it is connected", || {
        writer.publish(&value(0.0)).unwrap();
        node.ask(&json!(["arrived", "/demo/speed"])) == json!(true)
    });
    for n in 1..20 {
        writer.publish(&value(f64::from(n))).unwrap();
        let mut sample = node.ask(&json!(["sample", "/demo/speed"]));
        while n == 1 && sample == json!(float(0.0)) {
            sample = node.ask(&json!(["sample", "/demo/speed"]));
        }
        assert_eq!(sample, float(f64::from(n)));
    }
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn a_port_reads_every_sample_that_hiroz_writes_in_order() {
    let place = Place::new();
    let ros2 = place.open();
    let port = speed();
    let mut reader =
        ros2.subscription(&PortSpec::new(&port, &double()), Policy::Queue(32)).unwrap();
    let mut node = node(&place);
    node.ask(&json!(["write", "/demo/speed", FLOAT, FLOAT_HASH]));
    let mut got = Record::new(&double());
    eventually("it is connected", || {
        node.ask(&json!(["put", "/demo/speed", float(0.0)]));
        reader.read(&mut got).unwrap() == Reading::New
    });
    // Zeros may still come, as many as were put until one was read.
    let mut last = 0.0;
    for n in 1..20 {
        node.ask(&json!(["put", "/demo/speed", float(f64::from(n))]));
        eventually("it arrives", || {
            if reader.read(&mut got).unwrap() == Reading::New {
                let now = read_of(&got);
                assert!(now == last || now == last + 1.0, "{now} after {last}");
                last = now;
            }
            last == f64::from(n)
        });
    }
    assert_eq!(reader.dropped(), 0);
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn late_readers_get_the_last_value_of_hiroz_and_hiroz_that_of_a_port_if_it_is_transient_local() {
    let place = Place::new();
    let ros2 = place.open();
    let quality = Quality { transient_local: Some(true), ..Quality::default() };
    let at = speed();
    let mut writer = ros2.publisher(&PortSpec::new(&at, &double()).of(quality)).unwrap();
    for n in 1..30 {
        writer.publish(&value(f64::from(n))).unwrap();
    }
    let mut node = node(&place);
    node.ask(&json!(["read", "/demo/speed", FLOAT, FLOAT_HASH, true]));
    while node.ask(&json!(["sample", "/demo/speed"])) != json!(float(29.0)) {}
    writer.publish(&value(30.0)).unwrap();
    assert_eq!(node.ask(&json!(["sample", "/demo/speed"])), float(30.0), "the next one, too");

    node.ask(&json!(["write", "/demo/height", FLOAT, FLOAT_HASH, true]));
    for n in 1..4 {
        node.ask(&json!(["put", "/demo/height", float(f64::from(n))]));
    }
    let at = Address::new("demo", "height");
    let mut late = ros2.subscription(&PortSpec::new(&at, &double()), Policy::Latest).unwrap();
    let mut got = Record::new(&double());
    eventually("the last value arrives", || {
        late.read(&mut got).unwrap() == Reading::New && read_of(&got) == 3.0
    });
    assert_eq!(late.dropped(), 0);
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn what_hiroz_writes_is_listed_until_it_is_closed_or_killed() {
    let place = Place::new();
    let ros2 = place.open();
    let mut node = node(&place);
    let listed = |name: &str| {
        let known = ros2.discover().unwrap();
        known.iter().any(|end| {
            let writer =
                (end.kind, end.ty.as_str()) == (EndpointKind::Publisher, "std_msgs/msg/Float64");
            writer && end.address == name
        })
    };
    for name in ["demo/speed", "demo/height"] {
        node.ask(&json!(["write", format!("/{name}"), FLOAT, FLOAT_HASH]));
        eventually("it is listed", || listed(name));
    }
    assert_eq!(node.ask(&json!(["close", "/demo/speed"])), true);
    eventually("the closed one is gone", || !listed("demo/speed"));
    assert!(listed("demo/height"));
    // Killed. The lease that hiroz announces is 60 s: its connection tells of its end.
    drop(node);
    eventually("the other one is gone", || !listed("demo/height"));
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn ends_of_hiroz_whose_type_has_another_hash_are_told_of_with_both_hashes() {
    let place = Place::new();
    let ros2 = place.open();
    let height = Address::new("demo", "height");
    let _writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let _reader = ros2.subscription(&PortSpec::new(&height, &double()), Policy::Latest).unwrap();
    let mut node = node(&place);
    let other = FLOAT_HASH.replace('7', "8");
    node.ask(&json!(["read", "/demo/speed", FLOAT, other]));
    node.ask(&json!(["write", "/demo/height", FLOAT, other]));
    for (at, end) in [(speed(), "reader"), (height, "writer")] {
        let mut told = Vec::new();
        eventually("it is told", || {
            told = ros2.obstacles(&at);
            !told.is_empty()
        });
        let what = format!(
            "a {end} of {at} on ros2 means another structure by std_msgs/msg/Float64: {other}, \
             and the port {FLOAT_HASH}"
        );
        assert_eq!(told.iter().map(|one| &one.what).collect::<Vec<_>>(), [&what]);
    }
}

fn masquerading(place: &Place) -> Arc<Ros2> {
    let masquerade = [("::demo::reset".to_owned(), "std_srvs/srv/Trigger".to_owned())].into();
    Ros2::open(&Options { masquerade, ..place.options() }).unwrap()
}

/// Refuses all that it is asked.
struct Refuses;

impl ServiceHandler for Refuses {
    fn request(&self, _: Record, replies: Box<dyn Replies>) {
        let name = "::demo::TOO_FAR".to_owned();
        replies.finish(Outcome::Exception { name, detail: json!({"by": 3}) });
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_calls_a_service_and_gets_its_exception() {
    let place = Place::new();
    let ros2 = masquerading(&place);
    let at = Address::new("demo", "reset");
    let served = ros2.serve(&at, &reset(), Arc::new(Refuses)).unwrap();
    let mut node = node(&place);
    assert_eq!(node.ask(&json!(["client", "/demo/reset", TRIGGER, TRIGGER_HASH])), true);
    let reply = node.ask(&json!(["call", "/demo/reset", "0001000000"]));
    let told: String =
        "::demo::TOO_FAR {\"by\":3}".bytes().map(|byte| format!("{byte:02x}")).collect();
    let reply = reply.as_str().unwrap();
    assert!(reply.starts_with("0001000000") && reply.contains(&told), "{reply}");
    drop(served);
    let services = |node: &mut Peer| node.ask(&json!(["services"])).to_string();
    eventually("it is gone from the graph", || !services(&mut node).contains("/demo/reset"));
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn a_service_of_hiroz_is_called_it_throws_and_one_of_another_hash_is_refused() {
    let place = Place::new();
    let ros2 = masquerading(&place);
    let mut node = node(&place);
    let responses =
        json!([{"success": true, "message": ""}, {"success": false, "message": "it is stuck"}]);
    node.ask(&json!(["serve", "/robot/reset", TRIGGER, TRIGGER_HASH, responses]));
    let at = Address::new("robot", "reset");
    let listed = |name: &str| {
        let known = ros2.discover().unwrap();
        known.iter().any(|end| end.kind == EndpointKind::Service && end.address == name)
    };
    eventually("it is listed", || listed("robot/reset"));
    let mut client = ros2.client(&at, &reset()).unwrap();
    let nothing = Record::new(&reset().input);
    let mut call = || client.call(&nothing, Duration::from_secs(30));
    let outcome = call();
    assert!(matches!(outcome, Ok(Outcome::Success(_))), "{outcome:?}");
    match call() {
        Ok(Outcome::Exception { detail, .. }) => assert_eq!(detail, json!({"what": "it is stuck"})),
        other => panic!("no exception: {other:?}"),
    }
    assert_eq!(node.ask(&json!(["close", "/robot/reset"])), true);
    eventually("it is gone", || !listed("robot/reset"));

    let other = TRIGGER_HASH.replace('e', "f");
    node.ask(&json!(["serve", "/other/reset", TRIGGER, other, responses]));
    let at = Address::new("other", "reset");
    eventually("it is refused", || match ros2.client(&at, &reset()) {
        Err(OpenError::TypeMismatch { theirs, .. }) => theirs.contains(&other),
        Err(error) => panic!("{error}"),
        Ok(_) => false,
    });
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_lists_a_node_with_its_topic_and_its_type_until_it_is_closed() {
    let place = Place::new();
    let ros2 = place.open();
    let writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut node = node(&place);
    assert_eq!(node.ask(&json!(["nodes", "/demo"])), true);
    let expected: Value = json!(["/demo/speed", FLOAT]);
    eventually("its topic is listed with its type", || {
        node.ask(&json!(["topics"])).as_array().unwrap().contains(&expected)
    });
    drop(writer);
    assert_eq!(node.ask(&json!(["no node", "/demo"])), false);
}
