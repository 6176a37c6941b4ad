//! Services and actions that a genuine ROS 2 node serves, called as a component's remotes call them.

use std::path::Path;

use genom_conformance::eventually;
use genom_middleware::reply::{Reply, ReplyReceiver, pair};
use genom_middleware::{Discovery, EndpointKind, Running};

use super::*;

/// A client of a service or an action that a node of ROS serves, as soon as that is known here. Of
/// an action, what is listed are the services that it is made of.
fn client_of_node(ros2: &Ros2, at: &Address, ty: &ServiceType) -> Box<dyn Client> {
    let goals = format!("{at}/_action/send_goal");
    let name = if ty.kind == ServiceKind::Activity { goals } else { at.to_string() };
    eventually("the service of the node is listed", || {
        let known = ros2.discover().unwrap();
        known.iter().any(|end| end.kind == EndpointKind::Service && end.address == name)
    });
    ros2.client(at, ty).unwrap()
}

/// Starts an activity, and waits until it is accepted.
fn begin(client: &mut dyn Client, input: &Record) -> (Box<dyn Running>, ReplyReceiver) {
    let (replies, reply) = pair();
    let running = client.request(input, Box::new(replies)).unwrap();
    assert!(matches!(reply.next(PATIENCE), Ok(Reply::Accepted(_))));
    (running, reply)
}

#[test]
fn services_that_a_ros_node_serves_are_called() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = open(&domain);
    let mut peer = peer(&domain);
    let replies = [
        json!({"success": true, "message": "it is on"}),
        json!({"success": false, "message": "it is stuck"}),
    ];
    peer.ask(&json!(["serve", "/robot/enable", "std_srvs/srv/SetBool", replies]));
    peer.ask(&json!(["serve", "/robot/reset", "std_srvs/srv/Trigger", replies]));
    let mut client = client_of_node(&ros2, &Address::new("robot", "enable"), &enable());
    for (on, expected) in [(true, &replies[0]), (false, &replies[1])] {
        match call(&mut *client, &record(&enable().input, &json!({ "on": on }))) {
            Outcome::Success(output) => assert_eq!(output.to_json(), *expected),
            other => panic!("no reply: {other:?}"),
        }
        assert_eq!(peer.ask(&json!(["asked", "/robot/enable"])), json!({ "data": on }));
    }
    // Of a service without outputs, success and message are the outcome.
    let mut client = client_of_node(&ros2, &Address::new("robot", "reset"), &reset());
    let nothing = Record::new(&reset().input);
    assert!(matches!(call(&mut *client, &nothing), Outcome::Success(_)));
    match call(&mut *client, &nothing) {
        Outcome::Exception { detail, .. } => assert_eq!(detail, json!({"what": "it is stuck"})),
        other => panic!("no exception: {other:?}"),
    }
}

#[test]
fn an_action_that_a_ros_node_serves_runs_and_is_cancelled_as_an_activity() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = open(&domain);
    let mut peer = peer(&domain);
    let action = "/robot/count";
    peer.ask(&json!(["serve action", action, "test_msgs/action/Fibonacci"]));
    let mut client = client_of_node(&ros2, &Address::new("robot", "count"), &count());
    let mut begin = |peer: &mut Peer, most: i32| {
        let begun = begin(&mut *client, &record(&count().input, &json!({ "most": most })));
        assert_eq!(peer.ask(&json!(["asked", action])), json!({ "order": most }));
        begun
    };
    let (_running, reply) = begin(&mut peer, 3);
    peer.ask(&json!(["end", action, "succeed", {"sequence": [1, 2, 3]}]));
    match reply.wait(PATIENCE).unwrap() {
        Outcome::Success(output) => assert_eq!(output.to_json(), json!({"numbers": [1, 2, 3]})),
        other => panic!("no result: {other:?}"),
    }
    let (_running, reply) = begin(&mut peer, 4);
    peer.ask(&json!(["end", action, "abort", {}]));
    let ended = reply.wait(PATIENCE).unwrap();
    assert!(matches!(&ended, Outcome::Exception { name, .. } if name == "::genom::mwerr"));
    let (running, reply) = begin(&mut peer, 5);
    running.cancel();
    peer.ask(&json!(["to cancel", action]));
    peer.ask(&json!(["end", action, "canceled", {}]));
    let ended = reply.wait(PATIENCE).unwrap();
    assert!(matches!(&ended, Outcome::Exception { name, .. } if name == "::genom::interrupted"));
}

/// A node that has the demo's own types, built of its package.
fn peer_with_types(domain: &Domain) -> Peer {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/ros2/demo");
    let types = genom_components::ros2::types(&package.canonicalize().unwrap()).unwrap();
    let mut node = genom_components::ros2::node(domain.number().into(), Some(&types)).unwrap();
    Peer::start(&mut node)
}

#[test]
fn a_ros_node_that_serves_types_of_a_component_throws_its_exceptions_and_tells_its_states() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let mut peer = peer_with_types(&domain);
    let exception =
        |name: &str, detail: &str| json!({"genom_exception": name, "genom_detail": detail});
    let too_fast = exception("::demo::OUT_OF_RANGE", "{\"value\":9.0}");
    let replies = [exception("", ""), too_fast];
    peer.ask(&json!(["serve", "/axis/set_speed", "demo/srv/SetSpeed", replies]));
    let set_speed = service(ServiceKind::Attribute, "set_speed", &[("velocity", DOUBLE)], &[]);
    let mut client = client_of_node(&ros2, &Address::new("axis", "set_speed"), &set_speed);
    let velocity = record(&set_speed.input, &json!({"velocity": 9.0}));
    assert!(matches!(call(&mut *client, &velocity), Outcome::Success(_)));
    match call(&mut *client, &velocity) {
        Outcome::Exception { name, detail } => {
            assert_eq!((name.as_str(), detail), ("::demo::OUT_OF_RANGE", json!({"value": 9.0})));
        }
        other => panic!("no exception: {other:?}"),
    }

    let action = "/axis/goto";
    peer.ask(&json!(["serve action", action, "demo/action/Goto"]));
    let goto = service(ServiceKind::Activity, "goto", &[("goal", DOUBLE)], &[]);
    let mut client = client_of_node(&ros2, &Address::new("axis", "goto"), &goto);
    let goal = record(&goto.input, &json!({"goal": 0.5}));
    let mut ended = |how: &str, result: Value| {
        let (_running, reply) = begin(&mut *client, &goal);
        assert_eq!(peer.ask(&json!(["asked", action])), json!({"goal": 0.5}));
        peer.ask(&json!(["feed", action, {"genom_state": "main"}]));
        assert!(matches!(reply.next(PATIENCE), Ok(Reply::Feedback(state)) if state == "main"));
        peer.ask(&json!(["end", action, how, result]));
        reply.wait(PATIENCE).unwrap()
    };
    assert!(matches!(ended("succeed", exception("", "")), Outcome::Success(_)));
    match ended("abort", exception("::demo::HALTED", "")) {
        Outcome::Exception { name, .. } => assert_eq!(name, "::demo::HALTED"),
        other => panic!("no exception: {other:?}"),
    }
    // A node that knows nothing of exceptions leaves them empty.
    match ended("abort", json!({})) {
        Outcome::Exception { name, detail } => {
            assert_eq!((name.as_str(), detail), ("::genom::mwerr", json!({"what": "it failed"})));
        }
        other => panic!("no exception: {other:?}"),
    }
}
