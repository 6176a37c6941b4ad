//! The mode `zenoh` together with a node that speaks as `rmw_zenoh_cpp` does, made independently on
//! plain zenoh (`rmw_zenoh.py`). Hashes are those that ROS 2 Jazzy publishes.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

mod actions;
mod buffers;
mod own_services;
#[path = "world/services.rs"]
mod services;
mod told;
#[path = "world/zenoh.rs"]
mod world;

use std::io::Read as _;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_components::peer::Peer;
use genom_conformance::eventually;
use genom_conformance::samples::basic;
use genom_middleware::{
    ActivityId, Address, CallError, Discovery, EndpointKind, Middleware, OpenError, Outcome,
    Policy, PortSpec, Ports, Quality, Reading, Replies, ServiceHandler, ServiceKind, Services,
};
use genom_ros2::{Options, Ros2};
use genom_types::{DataType, Kind, Record};
use serde_json::{Value, json};
use services::{DOUBLE, count, reset, service};
use world::Place;

const FLOAT: &str = "std_msgs::msg::dds_::Float64_";
const FLOAT_HASH: &str = "RIHS01_705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a";
const TRIGGER: &str = "std_srvs::srv::dds_::Trigger_";
const TRIGGER_HASH: &str =
    "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";

/// Starts a node; with `router`, it is the router as well.
fn node(place: &Place, router: bool) -> Peer {
    let packages = ["eclipse-zenoh==1.10.2", "xxhash==3.5.0"];
    let python = genom_components::python::environment(&packages)
        .unwrap_or_else(|error| panic!("the peer in Python cannot be had: {error}"));
    let mut command = Command::new(python);
    command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rmw_zenoh.py")).arg(place.router());
    command.args(router.then_some("router"));
    Peer::start(&mut command)
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

fn record(ty: &DataType, value: &Value) -> Record {
    let mut record = Record::new(ty);
    record.merge_json(value).unwrap();
    record
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
fn a_node_reads_a_port_and_every_sample_has_its_number_and_the_gid_of_the_port() {
    let place = Place::new();
    let ros2 = place.open();
    let mut writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut node = node(&place, false);
    assert_eq!(node.ask(&json!(["read", "/demo/speed", FLOAT, FLOAT_HASH, false])), "ready");
    let ends = node.ask(&json!(["there", "/MP/%/%/demo/%demo%speed/"]));
    let (token, gid) = ends.as_object().unwrap().iter().next().unwrap();
    assert!(token.ends_with(&format!("/{FLOAT}/{FLOAT_HASH}/::,16:,:,:,,")), "{token}");
    let nodes = node.ask(&json!(["there", "/NN/%/%/demo"]));
    assert_eq!(nodes.as_object().unwrap().len(), 1);
    eventually("it is connected", || {
        writer.publish(&value(0.0)).unwrap();
        node.ask(&json!(["arrived", "/demo/speed"])) == json!(true)
    });
    let mut first = 0;
    for n in 1..20 {
        writer.publish(&value(f64::from(n))).unwrap();
        let mut sample = node.ask(&json!(["sample", "/demo/speed"]));
        while n == 1 && sample["body"] == json!(float(0.0)) {
            sample = node.ask(&json!(["sample", "/demo/speed"]));
        }
        assert_eq!((&sample["body"], &sample["size"]), (&json!(float(f64::from(n))), &json!(33)));
        assert_eq!((&sample["gid"], &sample["recent"]), (gid, &json!(true)));
        let number = sample["number"].as_i64().unwrap();
        first = if n == 1 { number } else { first };
        assert_eq!(number, first + i64::from(n) - 1);
    }
    drop(writer);
    assert_eq!(node.ask(&json!(["gone", "/MP/%/%/demo/"])), "gone");
    assert_eq!(node.ask(&json!(["gone", "/NN/%/%/demo"])), "gone");
}

#[test]
fn a_port_reads_what_a_node_writes_and_counts_what_was_lost() {
    let place = Place::new();
    let ros2 = place.open();
    let mut reader =
        ros2.subscription(&PortSpec::new(&speed(), &double()), Policy::Queue(8)).unwrap();
    let mut node = node(&place, false);
    node.ask(&json!(["there", "/MS/"]));
    node.ask(&json!(["write", "/demo/speed", FLOAT, FLOAT_HASH, false]));
    node.ask(&json!(["matched", "/demo/speed"]));
    let mut got = Record::new(&double());
    for n in 1..9 {
        let n = f64::from(n);
        node.ask(&json!(["put", "/demo/speed", float(n)]));
        eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
        assert_eq!(read_of(&got), n);
    }
    let seen = ros2.discover().unwrap();
    let theirs = |end: &&genom_middleware::Endpoint| end.kind == EndpointKind::Publisher;
    let theirs: Vec<_> = seen.iter().filter(theirs).collect();
    assert_eq!(theirs.len(), 1, "{seen:?}");
    let end = (theirs[0].address.as_str(), theirs[0].ty.as_str());
    assert_eq!(end, ("demo/speed", "std_msgs/msg/Float64"));
    assert_eq!(reader.dropped(), 0);
    node.ask(&json!(["put", "/demo/speed", float(9.0), 3]));
    eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!((read_of(&got), reader.dropped()), (9.0, 3));
    // A program that is no ROS node attaches nothing.
    node.ask(&json!(["plain", "/demo/speed", FLOAT, FLOAT_HASH, float(10.0)]));
    eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!((read_of(&got), reader.dropped()), (10.0, 3));
    // Killed.
    drop(node);
    eventually("it is gone from the list", || {
        !ros2.discover().unwrap().iter().any(|end| end.kind == EndpointKind::Publisher)
    });
}

#[test]
fn late_readers_get_the_last_value_both_ways_if_it_is_transient_local() {
    let place = Place::new();
    let ros2 = place.open();
    let mut node = node(&place, false);
    let quality = Quality { transient_local: Some(true), ..Quality::default() };
    let at = speed();
    let mut writer = ros2.publisher(&PortSpec::new(&at, &double()).of(quality)).unwrap();
    for n in 1..30 {
        writer.publish(&value(f64::from(n))).unwrap();
    }
    node.ask(&json!(["there", "/%demo%speed/"]));
    node.ask(&json!(["read", "/demo/speed", FLOAT, FLOAT_HASH, true]));
    let mut last = Value::Null;
    while last != json!(float(29.0)) {
        last = node.ask(&json!(["sample", "/demo/speed"]))["body"].clone();
    }
    node.ask(&json!(["write", "/demo/height", FLOAT, FLOAT_HASH, true]));
    for n in 1..4 {
        node.ask(&json!(["put", "/demo/height", float(f64::from(n))]));
    }
    let at = Address::new("demo", "height");
    let mut late = ros2.subscription(&PortSpec::new(&at, &double()), Policy::Latest).unwrap();
    let mut got = Record::new(&double());
    eventually("the last value arrives", || late.read(&mut got).unwrap() == Reading::New);
    assert_eq!((read_of(&got), late.dropped()), (3.0, 0));
}

fn masquerading(place: &Place) -> Arc<Ros2> {
    let masquerade = [
        ("::demo::reset", "std_srvs/srv/Trigger"),
        ("::demo::count", "test_msgs/action/Fibonacci"),
    ];
    let masquerade = masquerade.map(|(ours, ros)| (ours.to_owned(), ros.to_owned()));
    Ros2::open(&Options { masquerade: masquerade.into(), ..place.options() }).unwrap()
}

/// Does what it is asked once, and refuses the next request.
#[derive(Default)]
struct Once(Mutex<u32>);

impl ServiceHandler for Once {
    fn request(&self, _: Record, replies: Box<dyn Replies>) {
        let mut calls = self.0.lock().unwrap();
        *calls += 1;
        replies.finish(if *calls == 1 {
            Outcome::Success(Record::new(&reset().output))
        } else {
            Outcome::Exception { name: "::demo::TOO_FAR".to_owned(), detail: json!({"by": 3}) }
        });
    }

    fn cancel(&self, _: ActivityId) {}
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A response of `Trigger` in CDR.
fn triggered(success: bool, message: &str) -> String {
    let length = u32::try_from(message.len() + 1).unwrap().to_le_bytes();
    let head = [0, 1, 0, 0, u8::from(success), 0, 0, 0];
    hexadecimal(&[&head[..], &length, message.as_bytes(), &[0]].concat())
}

#[test]
fn a_node_calls_a_service_and_gets_its_number_and_gid_back() {
    let place = Place::new();
    let ros2 = masquerading(&place);
    let _served =
        ros2.serve(&Address::new("demo", "reset"), &reset(), Arc::new(Once::default())).unwrap();
    let mut node = node(&place, false);
    node.ask(&json!(["client", "/demo/reset", TRIGGER, TRIGGER_HASH]));
    // A request without members is one byte.
    let mut call = || node.ask(&json!(["call", "/demo/reset", "0001000000"]));
    let reply = call();
    assert_eq!(reply["body"], triggered(true, ""));
    assert_eq!((&reply["ours"], &reply["recent"]), (&json!(true), &json!(true)));
    let reply = call();
    assert_eq!(reply["body"], triggered(false, "::demo::TOO_FAR {\"by\":3}"));
    assert_eq!(reply["ours"], true);
}

#[test]
fn a_service_of_a_node_is_called_and_one_of_another_hash_is_refused_with_both_named() {
    let place = Place::new();
    let ros2 = masquerading(&place);
    let at = Address::new("demo", "reset");
    let mut node = node(&place, false);
    node.ask(&json!(["serve", "/demo/reset", TRIGGER, TRIGGER_HASH, triggered(true, "done")]));
    let mut client = ros2.client(&at, &reset()).unwrap();
    for _ in 0..3 {
        let outcome = client.call(&Record::new(&reset().input), Duration::from_secs(30));
        assert!(matches!(outcome, Ok(Outcome::Success(_))), "{outcome:?}");
    }
    let other = "RIHS01_0000000000000000000000000000000000000000000000000000000000000000";
    node.ask(&json!(["serve", "/other/reset", TRIGGER, other, triggered(true, "done")]));
    let at = Address::new("other", "reset");
    eventually("it is refused", || match ros2.client(&at, &reset()) {
        Err(OpenError::TypeMismatch { theirs, .. }) => theirs.contains(other),
        Err(error) => panic!("{error}"),
        Ok(_) => false,
    });
    let at = Address::new("nobody", "reset");
    let mut client = ros2.client(&at, &reset()).unwrap();
    let outcome = client.call(&Record::new(&reset().input), Duration::from_millis(50));
    assert!(matches!(outcome, Err(CallError::Nobody { .. })), "{outcome:?}");
}

#[test]
fn a_node_and_its_topic_have_the_names_that_were_given_to_them_until_these_are_taken_back() {
    let place = Place::new();
    let ros2 = place.open();
    ros2.masquerade("demo", "/lab/arm").unwrap();
    ros2.masquerade("demo/speed", "odom").unwrap();
    let writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut node = node(&place, false);
    node.ask(&json!(["there", "/NN/%/%lab/arm"]));
    node.ask(&json!(["there", "/MP/%/%lab/arm/%lab%odom/"]));
    assert_eq!(ros2.spelled(&speed()), "lab/odom");
    drop(writer);
    node.ask(&json!(["gone", "/NN/%/%lab/arm"]));
    ["demo", "demo/speed"].iter().for_each(|ours| ros2.unmask(ours));
    let _writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    node.ask(&json!(["there", "/MP/%/%/demo/%demo%speed/"]));
    assert!(ros2.masquerade("demo", "/2").is_err());
}

#[test]
fn ends_whose_type_has_another_hash_are_told_of_with_both_hashes() {
    let place = Place::new();
    let ros2 = place.open();
    let height = Address::new("demo", "height");
    let _writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let _reader = ros2.subscription(&PortSpec::new(&height, &double()), Policy::Latest).unwrap();
    let mut node = node(&place, false);
    let other = FLOAT_HASH.replace('7', "8");
    node.ask(&json!(["read", "/demo/speed", FLOAT, other, false]));
    node.ask(&json!(["write", "/demo/height", FLOAT, other, false]));
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
    // Those of the same hash are in nobody's way.
    node.ask(&json!(["read", "/demo/depth", FLOAT, FLOAT_HASH, false]));
    let depth = Address::new("demo", "depth");
    let _writer = ros2.publisher(&PortSpec::new(&depth, &double())).unwrap();
    node.ask(&json!(["there", "/MP/%/%/demo/%demo%depth/"]));
    assert_eq!(ros2.obstacles(&depth), []);
}

/// Environment variable with the router of the process that is killed.
const ROUTER: &str = "GENOM_ROS2_ZENOH_ROUTER";

#[test]
#[ignore = "is another process, which the next test starts"]
fn writes_until_it_is_killed() {
    let Ok(router) = std::env::var(ROUTER) else { return };
    let ros2 = Ros2::open(&world::options(&router)).unwrap();
    let mut writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let served = Arc::new(Once::default());
    let _served = ros2.serve(&Address::new("demo", "reset"), &reset(), served).unwrap();
    writer.publish(&value(9.0)).unwrap();
    // Ends with the test if it is not killed before.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

#[test]
fn a_killed_daemon_is_gone_from_the_lists_of_nodes_and_its_address_is_free() {
    let place = Place::new();
    let mut router = node(&place, true);
    let ros2 = place.open();
    let mut reader =
        ros2.subscription(&PortSpec::new(&speed(), &double()), Policy::Latest).unwrap();
    let mut writer = genom_conformance::again("writes_until_it_is_killed")
        .env(ROUTER, place.router())
        // Much longer than anything here waits: its connection tells of its end.
        .env("ZENOH_CONFIG_OVERRIDE", "transport/link/tx/lease=3600000")
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut got = Record::new(&double());
    eventually("its sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(read_of(&got), 9.0);
    router.ask(&json!(["there", "/MP/%/%/demo/%demo%speed/"]));
    router.ask(&json!(["there", "/SS/%/%/demo/%demo%reset/"]));
    let taken = ros2.publisher(&PortSpec::new(&speed(), &double()));
    assert!(matches!(taken, Err(OpenError::Taken { .. })));
    writer.kill().unwrap();
    writer.wait().unwrap();
    router.ask(&json!(["gone", "/%/%/demo/"]));
    router.ask(&json!(["gone", "/NN/%/%/demo"]));
    let mut next = None;
    eventually("the address is free", || {
        next = ros2.publisher(&PortSpec::new(&speed(), &double())).ok();
        next.is_some()
    });
    next.unwrap().publish(&value(10.0)).unwrap();
    eventually("the next writer is read", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(read_of(&got), 10.0);
}

#[test]
fn where_a_router_runs_this_process_is_none_and_becomes_it_when_that_one_is_gone() {
    let place = Place::new();
    let router = node(&place, true);
    let ros2 = place.open();
    let mut writer = ros2.publisher(&PortSpec::new(&speed(), &double())).unwrap();
    let mut one = node(&place, false);
    one.ask(&json!(["there", "/MP/%/%/demo/"]));
    // Killed.
    drop(router);
    // Whoever comes now finds the others through this process.
    let mut late = node(&place, false);
    late.ask(&json!(["read", "/demo/speed", FLOAT, FLOAT_HASH, true]));
    late.ask(&json!(["there", "/MP/%/%/demo/"]));
    writer.publish(&value(7.0)).unwrap();
    assert_eq!(late.ask(&json!(["sample", "/demo/speed"]))["body"], float(7.0));
}

#[test]
fn tokens_and_samples_that_are_no_ones_do_no_harm() {
    let place = Place::new();
    let ros2 = place.open();
    let mut reader =
        ros2.subscription(&PortSpec::new(&speed(), &double()), Policy::Queue(8)).unwrap();
    let mut node = node(&place, false);
    node.ask(&json!(["there", "/MS/"]));
    node.ask(&json!(["write", "/demo/speed", FLOAT, FLOAT_HASH, false]));
    node.ask(&json!(["matched", "/demo/speed"]));
    let mut got = Record::new(&double());
    node.ask(&json!(["put", "/demo/speed", "0001"]));
    eventually("it is refused", || reader.read(&mut got).is_err());
    node.ask(&json!(["put", "/demo/speed", ""]));
    eventually("it is refused", || reader.read(&mut got).is_err());
    node.ask(&json!(["put", "/demo/speed", float(3.0), i64::MAX - 100]));
    eventually("the sample arrives", || reader.read(&mut got).is_ok_and(|r| r == Reading::New));
    assert_eq!(reader.dropped(), 2 + u64::from(u32::MAX));
}
