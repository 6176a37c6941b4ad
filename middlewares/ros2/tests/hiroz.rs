//! The mode `zenoh` together with hiroz, an implementation of ROS 2 over zenoh that is not ours.
//! Hashes are those that ROS 2 Jazzy publishes.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

#[path = "world/zenoh.rs"]
mod world;

use std::sync::Arc;

use genom_components::hiroz;
use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_conformance::samples::basic;
use genom_middleware::{
    ActivityId, Address, Outcome, Policy, PortSpec, Ports, Reading, Replies, ServiceHandler,
    ServiceKind, ServiceType, Services,
};
use genom_ros2::{Options, Ros2};
use genom_types::{DataType, Kind, Member, Record, ScopedName, TypeTable};
use serde_json::{Value, json};
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

fn reset() -> ServiceType {
    let part = |part: &str| {
        let mut table = TypeTable::default();
        let name = ScopedName::new(["demo", "reset", part]);
        let id = table.add(Kind::Struct { name, members: Vec::<Member>::new() });
        DataType::new(&Arc::new(table), id).unwrap()
    };
    ServiceType::new(ServiceKind::Function, part("input"), part("output"))
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
    let masquerade = [("::demo::reset".to_owned(), "std_srvs/srv/Trigger".to_owned())].into();
    let ros2 = Ros2::open(&Options { masquerade, ..place.options() }).unwrap();
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
