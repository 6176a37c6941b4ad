//! What hiroz has a daemon do: actions, parameters, components that it loads, time.

use genom_tests::{component, path, until};
use serde_json::{Value, json};

use super::super::cdr::{CLOCK, Cdr, FLOAT, LOAD_NODE, bytes, date, text};
use super::daemons::World;

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_runs_an_activity_as_an_action_reads_its_states_and_gives_it_up() {
    let mut world = World::demo(&[]);
    let goto = world.of_demo("goto");
    let World { daemon, peer, .. } = &mut world;
    let mut ask = |verb: &str, more: &Value| match more {
        Value::Null => peer.ask(&json!([verb, goto])),
        more => peer.ask(&json!([verb, goto, more])),
    };
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    assert_eq!(ask("action", &Value::Null), true, "all of it is there");
    assert_eq!(ask("goal", &json!(0.01)), "accepted");
    assert_eq!(ask("status", &json!("Succeeded")), "Succeeded");
    assert_eq!(ask("result", &Value::Null), json!(["", ""]));
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.01);

    // With a gain of 0 it never arrives.
    daemon.ctl(&["pub", "demo/parameter", "0"]).expect_code(0);
    assert_eq!(ask("goal", &json!(1.0)), "accepted");
    // Short states may be missed; this one lasts.
    while ask("feedback", &Value::Null) != "main" {}
    assert_eq!(ask("status", &json!("Executing")), "Executing");
    assert_eq!(ask("cancel", &Value::Null), json!({"code": 0, "same": [true]}));
    assert_eq!(ask("status", &json!("Canceled")), "Canceled");
    // It braked and stopped, as described.
    assert_eq!(ask("result", &Value::Null), json!(["", ""]));
    // It has ended, so there is nothing to cancel.
    assert_eq!(ask("cancel", &Value::Null), json!({"code": 3, "same": []}));

    // A goal that the component refuses ends with its exception.
    assert_eq!(ask("goal", &json!(99.0)), "accepted");
    assert_eq!(ask("status", &json!("Aborted")), "Aborted");
    let refused = ask("result", &Value::Null);
    assert_eq!(refused[0], "::demo::OUT_OF_RANGE");
    let detail: Value = serde_json::from_str(refused[1].as_str().unwrap()).unwrap();
    assert_eq!(detail["value"], 99.0);
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_gets_types_descriptions_and_events_of_parameters_and_why_one_is_not_set() {
    let mut world = World::demo(&[]);
    let World { daemon, peer, namespace, .. } = &mut world;
    assert_eq!(peer.ask(&json!(["nodes", format!("{namespace}/demo")])), true);
    peer.ask(&json!(["parameter events"]));
    let told = peer.ask(&json!(["parameters", namespace, "demo", "velocity", [1.5, 9.0]]));
    assert_eq!(told["names"], json!(["use_sim_time", "velocity"]));
    assert_eq!(told["types"], json!(["Bool", "Double"]));
    assert_eq!(told["set"][0], json!([true, ""]));
    assert_eq!(told["set"][1][0], false);
    let why = told["set"][1][1].as_str().unwrap();
    assert!(why.starts_with("::demo::OUT_OF_RANGE {"), "{why}");
    assert_eq!(told["value"], 1.5);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 1.5\n");
    let described = &told["described"][1];
    assert_eq!((&described["name"], &described["type"]), (&json!("velocity"), &json!("Double")));
    let text = described["description"].as_str().unwrap();
    assert_eq!(text, "read by attribute get_speed, set by attribute set_speed");
    let event = peer.ask(&json!(["parameter event"]));
    let node = format!("{namespace}/demo");
    assert_eq!(event, json!({"node": node, "parameters": [["velocity", 1.5]], "deleted": 0}));
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_loads_a_component_into_the_container_lists_it_and_unloads_it() {
    let demo = component("demo");
    let configuration = format!("[container]\ncomponents = [{:?}]\n", path(&demo.library));
    let mut world = World::new(&configuration, &[]);
    let World { peer, namespace, .. } = &mut world;
    let of = |service: &str| format!("{namespace}/container/_container/{service}");
    let mut client = |service: &str, [ty, hash]: [&str; 2]| {
        assert_eq!(peer.ask(&json!(["client", of(service), ty, hash])), true, "{service}");
    };
    client("load_node", LOAD_NODE);
    let mut call = |service: &str, body: &str| {
        let reply = peer.ask(&json!(["call", of(service), format!("00010000{body}")]));
        bytes(reply.as_str().unwrap_or_else(|| panic!("{reply}")))
    };
    // Package, plugin, name and namespace of the node; what fills the last one up to a multiple of 4
    // is the level of its log, too. Then rules, parameters and extra arguments.
    let names = ["demo", "demo", "arm", "/base"].map(text).concat();
    let body = call("load_node", &format!("{names}{}", "00000000".repeat(3)));
    let mut reply = Cdr { all: &body[4..], at: 0 };
    assert_eq!((reply.octet(), reply.text()), (1, String::new()), "no error");
    assert_eq!(reply.text(), "/base/arm");
    reply.at = reply.at.next_multiple_of(8);
    let number = reply.number();
    assert_eq!(reply.number(), 0, "the upper half of its number");
    // One rule that is none; the longest is longer than a datagram.
    let names = ["demo", "", "", ""].map(text).concat();
    for length in [900, 100_000] {
        let rule = "x".repeat(length);
        let request = format!("{names}01000000{}{}", text(&rule), "00000000".repeat(2));
        let body = call("load_node", &request);
        let mut reply = Cdr { all: &body[4..], at: 0 };
        assert_eq!(reply.octet(), 0, "it is refused");
        let why = reply.text();
        assert!(why.starts_with(&format!("`{rule}` is no rule")), "{}", why.len());
    }
    assert_eq!(peer.ask(&json!(["nodes", "/base/arm"])), true);

    // The hashes of these two come from the daemon: there is no package to take them from.
    for (service, ty) in [("list_nodes", "ListNodes"), ("unload_node", "UnloadNode")] {
        let hash = peer.ask(&json!(["hash", of(service)]));
        let ty = format!("composition_interfaces::srv::dds_::{ty}_");
        assert_eq!(peer.ask(&json!(["client", of(service), ty, hash])), true, "{service}");
    }
    let mut call = |service: &str, body: &str| {
        let reply = peer.ask(&json!(["call", of(service), format!("00010000{body}")]));
        bytes(reply.as_str().unwrap_or_else(|| panic!("{reply}")))
    };
    let body = call("list_nodes", "00");
    let mut list = Cdr { all: &body[4..], at: 0 };
    assert_eq!((list.number(), list.text()), (1, "/base/arm".to_owned()));
    assert_eq!(list.number(), 1, "one number");
    list.at = list.at.next_multiple_of(8);
    assert_eq!(list.number(), number);

    let request = format!("{}00000000", number.to_le_bytes().map(|b| format!("{b:02x}")).concat());
    let body = call("unload_node", &request);
    let mut reply = Cdr { all: &body[4..], at: 0 };
    assert_eq!((reply.octet(), reply.text()), (1, String::new()), "no error");
    let body = call("unload_node", &request);
    let mut reply = Cdr { all: &body[4..], at: 0 };
    assert_eq!(reply.octet(), 0, "it is gone already");
    assert_eq!(reply.text(), format!("there is no component {number} in this container"));
    assert_eq!(peer.ask(&json!(["no node", "/base/arm"])), false);
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn components_live_in_the_time_that_hiroz_publishes() {
    let mut world = World::demo(&["--clock", "ros"]);
    let World { daemon, peer, .. } = &mut world;
    let now = || daemon.home().get("/clock")["now"].as_u64().expect("a date");
    let [ty, hash] = CLOCK;
    peer.ask(&json!(["write", "/clock", ty, hash]));
    assert_eq!(now(), 0);
    let mut milliseconds = 0;
    // Nobody tells when the publisher is known to the daemon.
    until("time passes", || {
        milliseconds += 1;
        peer.ask(&json!(["put", "/clock", date(milliseconds)]));
        now() > 0
    });
    let (told, reached) = (milliseconds, now());
    assert_eq!(reached % 1_000_000, 0);
    peer.ask(&json!(["put", "/clock", date(told + 500)]));
    until("all of it passes", || now() >= reached + 500_000_000);
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn a_port_reads_what_hiroz_writes_under_a_name_in_its_own_namespace() {
    let mut world = World::demo(&[]);
    let World { daemon, peer, .. } = &mut world;
    assert_eq!(peer.ask(&json!(["nodes", "/lab/peer"])), true);
    let [ty, hash] = FLOAT;
    peer.ask(&json!(["write", "gain", ty, hash, true]));
    // Little-endian: 0.25.
    peer.ask(&json!(["put", "gain", "00010000000000000000d03f"]));
    daemon.ctl(&["connect", "demo/parameter", "ros2:/lab/gain"]).expect_code(0);
    // The port is read only during a motion; this one is slow enough to last.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let echo = daemon.spawn(&["echo", "demo/parameter"]);
    echo.line_where(|line| line == "0.25");
}
