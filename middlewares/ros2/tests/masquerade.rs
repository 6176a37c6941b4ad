//! Services and activities that masquerade as ROS's own types, called by a genuine ROS 2 node.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod served;
#[path = "world/services.rs"]
mod services;
mod world;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_components::peer::Peer;
use genom_middleware::{
    ActivityId, Address, Client, Middleware, OpenError, Outcome, Replies, ServiceHandler,
    ServiceKind, ServiceType, Services,
};
use genom_ros2::{Options, Ros2, ServiceMapping};
use genom_types::{DataType, Kind, Record};
use serde_json::{Value, json};
use services::{BOOLEAN, DOUBLE, LONG, Make, count, reset, service};
use world::Domain;

/// Only a failing test waits this long.
const PATIENCE: Duration = Duration::from_secs(60);

fn peer(domain: &Domain) -> Peer {
    let node = genom_components::ros2::node(domain.number().into(), None);
    Peer::start(&mut node.unwrap_or_else(|error| panic!("there is no ROS 2: {error}")))
}

const TEXT: Make = |table| table.add(Kind::String { bound: Some(32) });

fn enable() -> ServiceType {
    let output: &[(&str, Make)] = &[("success", BOOLEAN), ("message", TEXT)];
    service(ServiceKind::Attribute, "enable", &[("on", BOOLEAN)], output)
}

fn open(domain: &Domain) -> Arc<Ros2> {
    let masquerade = [
        ("::demo::enable", "std_srvs/srv/SetBool"),
        ("::demo::reset", "std_srvs/srv/Trigger"),
        ("::demo::count", "test_msgs/action/Fibonacci"),
    ];
    let masquerade = masquerade.map(|(ours, ros)| (ours.to_owned(), ros.to_owned()));
    Ros2::open(&Options { masquerade: masquerade.into(), ..domain.options() }).unwrap()
}

fn record(ty: &DataType, value: &Value) -> Record {
    let mut record = Record::new(ty);
    record.merge_json(value).unwrap();
    record
}

fn too_far() -> Outcome {
    Outcome::Exception { name: "::demo::TOO_FAR".to_owned(), detail: json!({"by": 3}) }
}

/// Switches on; refuses to switch off, and refuses the second request without input.
struct Stubborn {
    ty: ServiceType,
    good: Value,
    calls: Mutex<Vec<Value>>,
}

impl Stubborn {
    fn new(ty: &ServiceType, good: Value) -> Arc<Self> {
        Arc::new(Self { ty: ty.clone(), good, calls: Mutex::default() })
    }
}

impl ServiceHandler for Stubborn {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        let mut calls = self.calls.lock().unwrap();
        calls.push(input.to_json());
        let refused = match input.to_json().get("on") {
            Some(on) => *on == json!(false),
            None => calls.len() > 1,
        };
        replies.finish(match refused {
            false => Outcome::Success(record(&self.ty.output, &self.good)),
            true => too_far(),
        });
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
fn a_ros_node_calls_a_set_bool_and_a_trigger() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = open(&domain);
    let good = json!({"success": true, "message": "it is on"});
    let (enabler, resetter) = (Stubborn::new(&enable(), good), Stubborn::new(&reset(), json!({})));
    let _enable = ros2.serve(&Address::new("demo", "enable"), &enable(), enabler.clone()).unwrap();
    let _reset = ros2.serve(&Address::new("demo", "reset"), &reset(), resetter.clone()).unwrap();
    let mut peer = peer(&domain);
    for (name, ros) in [("enable", "std_srvs/srv/SetBool"), ("reset", "std_srvs/srv/Trigger")] {
        assert_eq!(peer.ask(&json!(["client", format!("/demo/{name}"), ros])), "ready");
    }
    let mut call =
        |name: &str, values: Value| peer.ask(&json!(["call", format!("/demo/{name}"), values]));
    let reply = call("enable", json!({"data": true}));
    assert_eq!(reply, json!({"success": true, "message": "it is on"}));
    let reply = call("enable", json!({"data": false}));
    assert_eq!(reply, json!({"success": false, "message": "::demo::TOO_FAR {\"by\":3}"}));
    let heard = enabler.calls.lock().unwrap().clone();
    assert_eq!(heard, [json!({"on": true}), json!({"on": false})]);
    let reply = call("reset", json!({}));
    assert_eq!(reply, json!({"success": true, "message": ""}));
    let reply = call("reset", json!({}));
    assert_eq!(reply, json!({"success": false, "message": "::demo::TOO_FAR {\"by\":3}"}));
}

/// Counts up to its input; with 13 it runs until it is cancelled.
#[derive(Default)]
struct Counter(Mutex<Option<Box<dyn Replies>>>);

impl ServiceHandler for Counter {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        let most = input.to_json()["most"].as_i64().unwrap();
        replies.accepted(ActivityId(1));
        replies.feedback("start");
        match most {
            13 => *self.0.lock().unwrap() = Some(replies),
            7 => replies.finish(too_far()),
            most => {
                let numbers: Vec<_> = (1..=most).collect();
                let output = record(&count().output, &json!({ "numbers": numbers }));
                replies.finish(Outcome::Success(output));
            }
        }
    }

    fn cancel(&self, _: ActivityId) {
        if let Some(replies) = self.0.lock().unwrap().take() {
            let name = "::genom::interrupted".to_owned();
            replies.finish(Outcome::Exception { name, detail: Value::Null });
        }
    }
}

#[test]
fn a_ros_node_runs_an_activity_as_an_action_of_its_own() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = open(&domain);
    let at = Address::new("demo", "count");
    let _served = ros2.serve(&at, &count(), Arc::<Counter>::default()).unwrap();
    let mut peer = peer(&domain);
    let ready = peer.ask(&json!(["action", "/demo/count", "test_msgs/action/Fibonacci"]));
    assert_eq!(ready, "ready");
    let mut run = |order: i32, cancel: bool, status: &str, sequence: &[i32]| {
        assert_eq!(peer.ask(&json!(["goal", "/demo/count", { "order": order }])), true);
        if cancel {
            let canceling = peer.ask(&json!(["cancel", "/demo/count"]));
            assert_eq!(canceling, json!({"code": 0, "goals": 1}));
        }
        let result = peer.ask(&json!(["result", "/demo/count"]));
        assert_eq!(result, json!({"status": status, "result": {"sequence": sequence}}));
    };
    run(4, false, "SUCCEEDED", &[1, 2, 3, 4]);
    run(7, false, "ABORTED", &[]);
    run(13, true, "CANCELED", &[]);
    run(1, false, "SUCCEEDED", &[1]);
}

#[test]
fn daemons_call_each_other_under_these_names_too() {
    let domain = Domain::new(ServiceMapping::Cyclone);
    let (serving, calling) = (open(&domain), open(&domain));
    let at = Address::new("demo", "enable");
    let good = json!({"success": true, "message": "yes"});
    let _served = serving.serve(&at, &enable(), Stubborn::new(&enable(), good.clone())).unwrap();
    let mut client = calling.client(&at, &enable()).unwrap();
    match call(&mut *client, &record(&enable().input, &json!({"on": true}))) {
        Outcome::Success(output) => assert_eq!(output.to_json(), good),
        other => panic!("no reply: {other:?}"),
    }
    // The response contains everything: the ROS type has no other members.
    match call(&mut *client, &record(&enable().input, &json!({"on": false}))) {
        Outcome::Success(output) => assert_eq!(
            output.to_json(),
            json!({"success": false, "message": "::demo::TOO_FAR {\"by\":3}"})
        ),
        other => panic!("no reply: {other:?}"),
    }
    let at = Address::new("demo", "count");
    let _served = serving.serve(&at, &count(), Arc::<Counter>::default()).unwrap();
    let mut client = calling.client(&at, &count()).unwrap();
    match call(&mut *client, &record(&count().input, &json!({"most": 3}))) {
        Outcome::Success(output) => assert_eq!(output.to_json(), json!({"numbers": [1, 2, 3]})),
        other => panic!("no result: {other:?}"),
    }
    match call(&mut *client, &record(&count().input, &json!({"most": 7}))) {
        Outcome::Exception { name, .. } => assert_eq!(name, "::genom::mwerr"),
        other => panic!("no exception: {other:?}"),
    }
}

fn call(client: &mut dyn Client, input: &Record) -> Outcome {
    client.call(input, PATIENCE).unwrap()
}

#[test]
fn structures_that_differ_are_refused_and_both_are_shown() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = open(&domain);
    let told = |ty: &ServiceType| {
        let at = Address::new("demo", "x");
        let handler = Stubborn::new(ty, json!({}));
        match ros2.serve(&at, ty, handler).err() {
            Some(OpenError::Failed { why, .. }) => why,
            other => panic!("not refused: {other:?}"),
        }
    };
    let wrong = service(ServiceKind::Attribute, "enable", &[("on", LONG)], &[]);
    assert_eq!(
        told(&wrong),
        "the request of ::demo::enable and std_srvs/srv/SetBool_Request differ at `on`, there \
         `data`:\nthe request of ::demo::enable is\n  int32 on\n\
         std_srvs/srv/SetBool_Request is\n  bool data"
    );
    let wrong = service(ServiceKind::Activity, "reset", &[], &[]);
    assert_eq!(
        told(&wrong),
        "::demo::reset cannot go as std_srvs/srv/Trigger: it needs a package/action/Type"
    );
    ros2.masquerade("::demo::look", "camera_msgs/srv/Look").unwrap();
    let unknown = told(&service(ServiceKind::Function, "look", &[], &[]));
    assert!(unknown.contains("camera_msgs/srv/Look is not known"), "{unknown}");
    assert!(
        ros2.masquerade("::demo::look", "Look")
            .unwrap_err()
            .to_string()
            .contains("package/msg/Type")
    );
}
