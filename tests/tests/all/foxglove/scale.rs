//! Many components.

use genom_tests::{Home, component};
use serde_json::json;

use super::visitor::{CALL, Client, address, source};

#[test]
fn fifty_components_are_shown_at_once() {
    let demo = component("demo");
    let mut text = source(CALL);
    for number in 0..50 {
        let library = demo.library.display();
        let cell = if number % 10 == 9 { "cell = \"apart\"\n" } else { "" };
        text.push_str(&format!(
            "[[component]]\nlibrary = \"{library}\"\nname = \"axis{number}\"\n{cell}"
        ));
    }
    let daemon = Home::new().configured(&text).start(&["--backend", "local"]);
    let mut client = Client::new(&daemon, &address(&daemon));
    for number in 0..50 {
        client.of_name("subscribe", &format!("/axis{number}/position"));
    }
    for number in 0..50 {
        // They move until the end of the test: what is published before the subscription has reached
        // the codels is only kept as the last value.
        let slowly = format!("/axis{number}/set_speed");
        client.ask("call", &[json!(slowly), json!({"velocity": 0.01})]);
        let goto = format!("/axis{number}/goto");
        let answer = client.ask("call", &[json!(goto), json!({"goal": 5.0})]);
        assert!(answer["result"]["activity"].is_u64(), "{answer}");
    }
    for number in 0..50 {
        let topic = format!("/axis{number}/position");
        client.ask("samples", &[json!(topic), json!(3)]);
    }
    client.ask("graph", &[]);
    daemon.ctl(&["connect", "--wait", "axis3/parameter", "far/gain"]).expect_code(0);
    let graph = client.ask("read", &[json!("/far/gain"), json!(["axis3"])]);
    let published = graph["published"].as_object().unwrap();
    assert_eq!(published.keys().filter(|topic| topic.ends_with("/position")).count(), 50);
    assert_eq!(client.ask("errors", &[]), json!([]));
}
