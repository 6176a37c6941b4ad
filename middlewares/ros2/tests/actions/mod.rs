//! Activities as actions over zenoh, which are services and topics of the node.

mod served;

use super::*;

const FIBONACCI: &str = "test_msgs::action::dds_::Fibonacci_";
const CANCEL: &str = "action_msgs::srv::dds_::CancelGoal_";
const CANCEL_HASH: &str = "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a";

/// The date in a request to cancel that means no date: that goal, whenever it was sent.
const NEVER: &str = "0000000000000000";

/// Counts up to its input, at once; with 13 it runs until it is cancelled.
#[derive(Default)]
struct Counter(Mutex<Option<Box<dyn Replies>>>);

impl ServiceHandler for Counter {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        let most = input.to_json()["most"].as_i64().unwrap();
        replies.accepted(ActivityId(1));
        replies.feedback("count");
        if most == 13 {
            *self.0.lock().unwrap() = Some(replies);
            return;
        }
        let numbers: Vec<_> = (0..most).collect();
        let output = record(&count().output, &json!({ "numbers": numbers }));
        replies.finish(Outcome::Success(output));
    }

    fn cancel(&self, _: ActivityId) {
        if let Some(replies) = self.0.lock().unwrap().take() {
            let name = "::genom::interrupted".to_owned();
            replies.finish(Outcome::Exception { name, detail: Value::Null });
        }
    }
}

#[test]
fn a_node_has_an_action_run_by_the_services_and_topics_that_it_is_made_of() {
    let place = Place::new();
    let ros2 = masquerading(&place);
    let _served =
        ros2.serve(&Address::new("demo", "count"), &count(), Arc::<Counter>::default()).unwrap();
    let mut node = node(&place, false);
    let of = |part: &str| FIBONACCI.replace("Fibonacci_", &format!("Fibonacci_{part}_"));
    let path = |part: &str| format!("/demo/count/_action/{part}");
    let parts = [
        (
            "send_goal",
            of("SendGoal"),
            "d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9",
        ),
        (
            "get_result",
            of("GetResult"),
            "5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209",
        ),
        ("cancel_goal", CANCEL.to_owned(), CANCEL_HASH),
    ];
    for (part, ty, hash) in &parts {
        node.ask(&json!(["client", path(part), ty, format!("RIHS01_{hash}")]));
    }
    for (part, ty, hash) in [
        (
            "feedback",
            of("FeedbackMessage"),
            "37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e",
        ),
        (
            "status",
            "action_msgs::msg::dds_::GoalStatusArray_".to_owned(),
            "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
        ),
    ] {
        let name = path(part).replace('/', "%");
        let ends = node.ask(&json!(["there", format!("/MP/%/%/demo/{name}/{ty}/RIHS01_{hash}/")]));
        assert_eq!(ends.as_object().unwrap().len(), 1);
    }
    let id = "0102030405060708090a0b0c0d0e0f10";
    let goal = format!("00010000{id}04000000");
    let accepted = node.ask(&json!(["call", path("send_goal"), goal]));
    assert!(accepted["body"].as_str().unwrap().starts_with("0001000001"), "{accepted}");
    assert_eq!(accepted["ours"], true);
    let result = node.ask(&json!(["call", path("get_result"), format!("00010000{id}")]));
    // Status 4, succeeded; then four numbers.
    let body = "00010000040000000400000000000000010000000200000003000000";
    assert_eq!(result["body"], body, "{result}");
    // A reader that comes late gets the status of the goals.
    let ty = "action_msgs::msg::dds_::GoalStatusArray_";
    let hash = "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e";
    node.ask(&json!(["read", path("status"), ty, hash, true]));
    let status = node.ask(&json!(["sample", path("status")]));
    let body = status["body"].as_str().unwrap();
    assert!(body.starts_with(&format!("0001000001000000{id}")) && body.ends_with("04"), "{body}");
}

/// The hash that a part of the action has in its token.
fn hash_of(node: &mut Peer, server: &str, part: &str, ty: &str) -> String {
    let ends = node.ask(&json!(["there", format!("/%{server}%count%_action%{part}/{ty}/")]));
    let (token, _) = ends.as_object().unwrap().iter().next().unwrap();
    token.split('/').find(|word| word.starts_with("RIHS01_")).unwrap().to_owned()
}

#[test]
fn a_node_reads_the_states_of_an_activity_as_feedback_and_cancels_it() {
    let place = Place::new();
    let ros2 = place.open();
    let handler = Arc::<Counter>::default();
    let _served = ros2.serve(&Address::new("demo", "count"), &count(), handler).unwrap();
    let mut node = node(&place, false);
    let path = |part: &str| format!("/demo/count/_action/{part}");
    let of = |part: &str| format!("demo::action::dds_::Count_{part}_");
    for (part, ty) in [
        ("send_goal", of("SendGoal")),
        ("get_result", of("GetResult")),
        ("cancel_goal", CANCEL.to_owned()),
    ] {
        let hash = hash_of(&mut node, "demo", part, &ty);
        node.ask(&json!(["client", path(part), ty, hash]));
    }
    let hash = hash_of(&mut node, "demo", "feedback", &of("FeedbackMessage"));
    node.ask(&json!(["read", path("feedback"), of("FeedbackMessage"), hash, false]));
    let send = |node: &mut Peer, id: &str, most: u8| {
        let goal = format!("00010000{id}{most:02x}000000");
        let accepted = node.ask(&json!(["call", path("send_goal"), goal]));
        assert!(accepted["body"].as_str().unwrap().starts_with("0001000001"), "{accepted}");
    };
    let mut goals = 0_u128;
    eventually("it is connected", || {
        goals += 1;
        send(&mut node, &format!("{goals:032x}"), 0);
        node.ask(&json!(["arrived", path("feedback")])) == json!(true)
    });
    let id = "f102030405060708090a0b0c0d0e0f10";
    send(&mut node, id, 13);
    // The goal, and the state: a string of six bytes with its NUL.
    let state = format!("00010000{id}06000000{}", hexadecimal(b"count\0"));
    while node.ask(&json!(["sample", path("feedback")]))["body"] != state {}

    // Another goal is unknown (2); this one is canceling (0), alone, and its date is told.
    let other = "ff".repeat(16);
    let cancel = |id: &str| json!(["call", path("cancel_goal"), format!("00010000{id}{NEVER}")]);
    let unknown = node.ask(&cancel(&other));
    assert_eq!(unknown["body"], "000100000200000000000000", "{unknown}");
    let canceling = node.ask(&cancel(id));
    let body = canceling["body"].as_str().unwrap();
    assert!(body.starts_with(&format!("000100000000000001000000{id}")), "{canceling}");
    assert_eq!(canceling["ours"], true);
    let result = node.ask(&json!(["call", path("get_result"), format!("00010000{id}")]));
    // Status 5, canceled, and why.
    let why = "::genom::interrupted\0";
    let body = result["body"].as_str().unwrap();
    let canceled =
        format!("0001000005000000{:02x}000000{}", why.len(), hexadecimal(why.as_bytes()));
    assert!(body.starts_with(&canceled), "{body}");
    // It has ended: there is nothing to cancel (3).
    let ended = node.ask(&cancel(id));
    assert_eq!(ended["body"], "000100000300000000000000", "{ended}");
}
