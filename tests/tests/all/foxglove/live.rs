//! Channels, samples, the graph and the time.

use std::collections::BTreeMap;

use genom_tests::{Daemon, component, path, request};
use serde_json::{Value, json};

use super::visitor::{CALL, Client, demo};

/// The channels of a file, by topic, as Foxglove advertises them.
fn recorded(daemon: &Daemon) -> BTreeMap<String, Value> {
    let file = daemon.home().path().join("all.mcap");
    daemon.ctl(&["record", "-o", path(&file), "--duration", "0.1"]).expect_code(0);
    let bytes = std::fs::read(file).expect("the file");
    let summary = mcap::Summary::read(&bytes).expect("whole").expect("a summary");
    let channels = summary.channels.values().map(|channel| {
        let schema = channel.schema.as_ref().expect("a schema");
        let told = json!({
            "topic": channel.topic, "encoding": channel.message_encoding,
            "schemaName": schema.name, "schemaEncoding": schema.encoding,
            "schema": String::from_utf8_lossy(&schema.data), "metadata": channel.metadata,
        });
        (channel.topic.clone(), told)
    });
    channels.collect()
}

#[test]
fn channels_and_their_schemas_are_those_of_a_recording() {
    let rust = component("demo-rs");
    let (daemon, address) = demo("", &[]);
    daemon.ctl(&["load", "--name", "other", path(&rust.library)]).expect_code(0);
    daemon.ctl(&["load", "--name", "apart", "--cell", "apart", path(&rust.library)]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "other/parameter", "elsewhere/gain"]).expect_code(0);
    let recorded = recorded(&daemon);
    for topic in
        ["/demo/position", "/other/parameter", "/apart/position", "/genom/calls", "/genom/changes"]
    {
        assert!(recorded.contains_key(topic), "{topic}: {recorded:?}");
    }
    for protocol in ["foxglove.websocket.v1", "foxglove.sdk.v1"] {
        let mut client = Client::of(&daemon, &address, protocol);
        client.of_name("channel", "/apart/position");
        let mut told = BTreeMap::new();
        for mut channel in client.ask("channels", &[]).as_array().expect("channels").clone() {
            channel.as_object_mut().unwrap().remove("id");
            let metadata = channel.get("metadata").cloned().unwrap_or_else(|| json!({}));
            channel["metadata"] = metadata;
            told.insert(channel["topic"].as_str().unwrap().to_owned(), channel);
        }
        assert_eq!(told, recorded, "{protocol}");
    }
}

#[test]
fn every_sample_of_a_subscription_arrives_once_with_its_date() {
    let (daemon, address) = demo("", &["--clock", "virtual"]);
    let mut client = Client::new(&daemon, &address);
    client.of_name("subscribe", "/demo/position");
    client.of_name("subscribe", "/genom/activities");
    daemon.ctl(&["start", "demo", "goto", "goal=0.25"]).expect_code(0);
    // Until the subscription has reached the codels, samples are only kept as last values.
    client.ask("sample", &[json!("/genom/activities"), json!({"event": "activity_started"})]);
    let mut steps = 0;
    let count = |client: &mut Client| {
        client.of_name("seen", "/demo/position")["count"].as_u64().unwrap_or_default()
    };
    while count(&mut client) == 0 {
        daemon.ctl(&["step", "5ms"]).expect_code(0);
        steps += 1;
        assert!(steps < 1000, "nothing arrives");
    }
    // While it moves, the subscriptions change twice: nothing is lost, nothing comes twice.
    let events = client.of_name("subscribe", "/genom/calls");
    daemon.ctl(&["step", "100ms"]).expect_code(0);
    client.ask("unsubscribe", &[events]);
    daemon.ctl(&["step", "2s"]).expect_code(0);
    let wanted = json!({"event": "activity_ended"});
    client.ask("sample", &[json!("/genom/activities"), wanted]);
    let last = client.ask("sample", &[json!("/demo/position"), json!({"position": 0.25})]);
    assert_eq!(last["velocity"], 0.0);
    let dates = client.of_name("seen", "/demo/position")["dates"].clone();
    let dates: Vec<_> =
        dates.as_array().unwrap().iter().map(|date| date.as_u64().unwrap()).collect();
    for pair in dates.windows(2) {
        assert_eq!(pair[1] - pair[0], 5_000_000, "every period once: {dates:?}");
    }
}

#[test]
fn nothing_arrives_after_the_last_subscription_ended() {
    let (daemon, address) = demo("", &[]);
    let mut client = Client::new(&daemon, &address);
    let subscribed = client.of_name("subscribe", "/demo/position");
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    client.ask("samples", &[json!("/demo/position"), json!(3)]);
    client.ask("unsubscribe", &[subscribed]);
    // What was under way has arrived when this is answered.
    client.of_name("send", "no message");
    client.is_told("none of the protocol");
    let count = client.of_name("seen", "/demo/position")["count"].clone();
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0.1"]).expect_code(0);
    client.of_name("subscribe", "/genom/calls");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
    client.ask("samples", &[json!("/genom/calls"), json!(1)]);
    assert_eq!(client.of_name("seen", "/demo/position")["count"], count);
}

#[test]
fn components_that_come_and_go_are_told() {
    let demo_rs = component("demo-rs");
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    client.of_name("subscribe", "/demo/position");
    daemon.ctl(&["load", "--name", "late", path(&demo_rs.library)]).expect_code(0);
    client.of_name("subscribe", "/late/position");
    client.of_name("service", "/late/goto");
    daemon.ctl(&["start", "--wait", "late", "goto", "goal=0.1"]).expect_code(0);
    client.ask("sample", &[json!("/late/position"), json!({"position": 0.1})]);
    daemon.ctl(&["unload", "late"]).expect_code(0);
    client.of_name("gone", "/late/position");
    // What remains is still served.
    daemon.ctl(&["start", "--wait", "demo", "goto", "goal=0.1"]).expect_code(0);
    client.ask("sample", &[json!("/demo/position"), json!({"position": 0.1})]);
    daemon.ctl(&["load", "--name", "late", path(&demo_rs.library)]).expect_code(0);
    client.of_name("channel", "/late/position");
}

#[test]
fn the_graph_follows_connections() {
    let rust = component("demo-rs");
    let (daemon, address) = demo(CALL, &[]);
    let mut client = Client::new(&daemon, &address);
    client.ask("graph", &[]);
    daemon.ctl(&["load", "--name", "other", path(&rust.library)]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "other/parameter", "far/gain"]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "demo/parameter", "far/gain"]).expect_code(0);
    let graph = client.ask("read", &[json!("/far/gain"), json!(["demo", "other"])]);
    assert_eq!(graph["published"]["/demo/position"], json!(["demo"]));
    assert_eq!(graph["services"]["/other/goto"], json!(["other"]));
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    client.ask("read", &[json!("/far/gain"), json!(["other"])]);
}

#[test]
fn the_time_is_told_if_it_is_virtual() {
    let (daemon, address) = demo("", &["--clock", "virtual"]);
    let mut client = Client::new(&daemon, &address);
    let able = client.ask("info", &[])["capabilities"].clone();
    assert!(able.as_array().unwrap().contains(&json!("time")), "{able}");
    let before = client.ask("times", &[json!(1)])[0].as_u64().unwrap();
    daemon.ctl(&["step", "1500ms"]).expect_code(0);
    let clock = request(&daemon.home().socket(), "GET", "/clock", "").body["now"].as_u64();
    assert!(clock >= Some(before + 1_500_000_000), "{clock:?} {before}");
    let mut count = 1;
    loop {
        count += 1;
        let times = client.ask("times", &[json!(count)]);
        if times.as_array().unwrap().last().unwrap().as_u64() == clock {
            break;
        }
    }
    let (daemon, address) = demo("", &[]);
    let able = Client::new(&daemon, &address).ask("info", &[])["capabilities"].clone();
    assert_eq!(able, json!(["connectionGraph"]), "that of the machine everybody has");
}
