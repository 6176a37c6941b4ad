//! An action that hiroz serves, run as a component's remotes run it.

use genom_middleware::reply::{Reply, pair};

use super::*;

/// Only a failing test waits so long.
const PATIENCE: Duration = Duration::from_secs(50);

const ACTION: &str = "/robot/count";

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn an_action_that_hiroz_serves_runs_tells_its_states_throws_and_is_cancelled_as_an_activity() {
    let place = Place::new();
    let ros2 = place.open();
    let mut client = ros2.client(&Address::new("robot", "count"), &count()).unwrap();
    let mut node = node(&place);
    node.ask(&json!(["serve action", ACTION]));
    eventually("its services are known", || {
        let ends = ros2.discover().unwrap();
        ends.iter().any(|end| end.address == "robot/count/_action/cancel_goal")
    });
    let mut begin = |node: &mut Peer, most: i32| {
        let (replies, reply) = pair();
        let mut input = Record::new(&count().input);
        input.merge_json(&json!({ "most": most })).unwrap();
        let running = client.request(&input, Box::new(replies)).unwrap();
        assert_eq!(node.ask(&json!(["asked", ACTION])), most);
        assert!(matches!(reply.next(PATIENCE), Ok(Reply::Accepted(_))));
        (running, reply)
    };
    let end = |how: &str, exception: &str, detail: &str, numbers: &[i32]| {
        json!(["end", ACTION, how, exception, detail, numbers])
    };

    let (_running, reply) = begin(&mut node, 3);
    for state in ["count", "rest"] {
        assert_eq!(node.ask(&json!(["feed", ACTION, state])), true);
        assert!(matches!(reply.next(PATIENCE), Ok(Reply::Feedback(told)) if told == state));
    }
    node.ask(&end("succeed", "", "", &[1, 2, 3]));
    match reply.wait(PATIENCE).unwrap() {
        Outcome::Success(output) => assert_eq!(output.to_json(), json!({"numbers": [1, 2, 3]})),
        other => panic!("no result: {other:?}"),
    }

    let (_running, reply) = begin(&mut node, 4);
    node.ask(&end("abort", "::demo::TOO_FAR", "{\"by\":3}", &[]));
    match reply.wait(PATIENCE).unwrap() {
        Outcome::Exception { name, detail } => {
            assert_eq!((name.as_str(), detail), ("::demo::TOO_FAR", json!({"by": 3})));
        }
        other => panic!("no exception: {other:?}"),
    }

    let (running, reply) = begin(&mut node, 5);
    running.cancel();
    assert_eq!(node.ask(&json!(["to cancel", ACTION])), true, "this goal");
    node.ask(&end("cancel", "::genom::interrupted", "", &[]));
    let ended = reply.wait(PATIENCE).unwrap();
    assert!(matches!(&ended, Outcome::Exception { name, .. } if name == "::genom::interrupted"));

    // Canceled, by one that stopped in an orderly way: it has its outputs (genom3.md 7.6).
    let (running, reply) = begin(&mut node, 6);
    running.cancel();
    assert_eq!(node.ask(&json!(["to cancel", ACTION])), true);
    node.ask(&end("cancel", "", "", &[6]));
    match reply.wait(PATIENCE).unwrap() {
        Outcome::Success(output) => assert_eq!(output.to_json(), json!({"numbers": [6]})),
        other => panic!("no result: {other:?}"),
    }
}
