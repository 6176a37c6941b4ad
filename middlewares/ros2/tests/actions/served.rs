//! An action that a node serves on plain zenoh, run as a component's remotes run it.

use genom_middleware::reply::{Reply, pair};

use super::*;

/// Only a failing test waits so long.
const PATIENCE: Duration = Duration::from_secs(50);

const ACTION: &str = "/robot/count/_action";

/// The texts of no exception, which stand before the outputs of a result.
const NO_EXCEPTION: &str = "01000000000000000100000000000000";

/// A node that has the three services and the feedback of `robot/count`, with the types that our
/// client asks for.
fn server(place: &Place) -> Peer {
    let mut node = node(place, false);
    let of = |part: &str| format!("demo::action::dds_::Count_{part}_");
    for (part, ty) in [
        ("send_goal", of("SendGoal")),
        ("get_result", of("GetResult")),
        ("cancel_goal", CANCEL.to_owned()),
    ] {
        let hash = hash_of(&mut node, "robot", part, &ty);
        node.ask(&json!(["hold", format!("{ACTION}/{part}"), ty, hash]));
    }
    let (feedback, ty) = (format!("{ACTION}/feedback"), of("FeedbackMessage"));
    let hash = hash_of(&mut node, "robot", "feedback", &ty);
    node.ask(&json!(["write", feedback, ty, hash, false]));
    node.ask(&json!(["matched", feedback]));
    node
}

#[test]
fn an_action_that_a_node_serves_runs_tells_its_states_and_is_cancelled_as_an_activity() {
    let place = Place::new();
    let ros2 = place.open();
    let mut client = ros2.client(&Address::new("robot", "count"), &count()).unwrap();
    let mut node = server(&place);
    let asked = |part: &str| json!(["asked", format!("{ACTION}/{part}")]);
    let answer = |part: &str, body: &str| {
        json!(["answer", format!("{ACTION}/{part}"), format!("00010000{body}")])
    };
    eventually("its services are known", || {
        let ends = ros2.discover().unwrap();
        ends.iter().any(|end| end.address == "robot/count/_action/get_result")
    });
    let mut begin = |node: &mut Peer, most: u8| {
        let (replies, reply) = pair();
        let input = record(&count().input, &json!({ "most": most }));
        let running = client.request(&input, Box::new(replies)).unwrap();
        // The goal, then its member.
        let request = node.ask(&asked("send_goal"));
        let request = request.as_str().unwrap().strip_prefix("00010000").unwrap().to_owned();
        let (id, member) = request.split_at(32);
        assert_eq!(member, format!("{most:02x}000000"));
        // Accepted, at no date.
        node.ask(&answer("send_goal", &format!("01000000{NEVER}")));
        assert!(matches!(reply.next(PATIENCE), Ok(Reply::Accepted(_))));
        let result = node.ask(&asked("get_result"));
        assert_eq!(result, format!("00010000{id}"), "the result of that goal is waited for");
        (running, reply, id.to_owned())
    };

    let (_running, reply, id) = begin(&mut node, 3);
    let state = format!("00010000{id}06000000{}", hexadecimal(b"count\0"));
    node.ask(&json!(["put", format!("{ACTION}/feedback"), state]));
    assert!(matches!(reply.next(PATIENCE), Ok(Reply::Feedback(state)) if state == "count"));
    // Succeeded (4), with three numbers.
    let numbers = "03000000010000000200000003000000";
    node.ask(&answer("get_result", &format!("04000000{NO_EXCEPTION}{numbers}")));
    match reply.wait(PATIENCE).unwrap() {
        Outcome::Success(output) => assert_eq!(output.to_json(), json!({"numbers": [1, 2, 3]})),
        other => panic!("no result: {other:?}"),
    }

    // Aborted (6), without an exception.
    let (_running, reply, _) = begin(&mut node, 4);
    node.ask(&answer("get_result", &format!("06000000{NO_EXCEPTION}00000000")));
    let ended = reply.wait(PATIENCE).unwrap();
    assert!(matches!(&ended, Outcome::Exception { name, .. } if name == "::genom::mwerr"));

    let (running, reply, id) = begin(&mut node, 5);
    running.cancel();
    assert_eq!(node.ask(&asked("cancel_goal")), format!("00010000{id}{NEVER}"));
    // It is cancelling (0), this goal.
    node.ask(&answer("cancel_goal", &format!("0000000001000000{id}{NEVER}")));
    // Canceled (5), by a server that stopped at once and says so.
    let why = format!(
        "15000000{}00000001000000{}",
        hexadecimal(b"::genom::interrupted\0"),
        "00".repeat(4)
    );
    node.ask(&answer("get_result", &format!("05000000{why}00000000")));
    let ended = reply.wait(PATIENCE).unwrap();
    assert!(matches!(&ended, Outcome::Exception { name, .. } if name == "::genom::interrupted"));

    // Canceled, by one that stopped in an orderly way: it has its outputs (genom3.md 7.6).
    let (_running, reply, _) = begin(&mut node, 6);
    node.ask(&answer("get_result", &format!("05000000{NO_EXCEPTION}{numbers}")));
    assert!(matches!(reply.wait(PATIENCE).unwrap(), Outcome::Success(_)));
}
