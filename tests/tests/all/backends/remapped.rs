//! Components with other names on ROS 2: `remap` of a configuration and `genomctl load --remap`
//! (ROS 2 design, "Remapping Names").

use genom_components::peer::Peer;
use genom_components::ros2;
use genom_tests::{Home, component, path, repository, request};
use serde_json::json;

#[test]
fn a_component_its_ports_and_services_have_the_names_that_rules_give_them() {
    let home = Home::new();
    let memory = home.memory();
    let namespace = format!("/{}", memory.prefix().trim_end_matches('_'));
    let types = ros2::types(&repository().join("tests/fixtures/ros2/demo")).unwrap();
    let mut node = ros2::node(memory.domain(), Some(&types)).unwrap();
    let library = component("demo").library;
    let library = path(&library);
    let home = home.configured(&format!(
        r#"
        backend = "ros2"
        [[component]]
        library = "{library}"
        name = "left"
        cell = "arm"
        remap = ["position:=/odom", "goto:=~/go", "__ns:=/base/one", "__node:=arm"]
        [[component]]
        library = "{library}"
        name = "right"
        remap = ["position:=odom"]
        "#
    ));
    let daemon = home.start(&[]);
    let mut peer = Peer::start(&mut node);
    let state = "demo/msg/State";
    let relative = format!("{namespace}/odom");
    for topic in ["/odom", &relative] {
        peer.ask(&json!(["read", topic, state]));
        assert_eq!(peer.ask(&json!(["sample", topic]))["position"], 0.0);
    }
    // Services that no rule is about have the name of the node in front; so have parameters.
    let arm = "/base/one/arm";
    peer.ask(&json!(["service", format!("{arm}/set_speed"), "arm", "/base/one"]));
    peer.ask(&json!(["service", format!("{namespace}/right/set_speed"), "right", namespace]));
    peer.ask(&json!(["parameters", arm]));
    assert_eq!(peer.ask(&json!(["list", arm]))["names"], json!(["use_sim_time", "velocity"]));
    let go = format!("{arm}/go");
    peer.ask(&json!(["action", go, "demo/action/Goto"]));
    assert_eq!(peer.ask(&json!(["goal", go, {"goal": 0.01}])), true);
    assert_eq!(peer.ask(&json!(["result", go]))["status"], "SUCCEEDED");
    let nodes = peer.ask(&json!(["nodes"]));
    let nodes: Vec<&str> =
        nodes.as_array().unwrap().iter().filter_map(|one| one.as_str()).collect();
    assert!(nodes.contains(&arm), "{nodes:?}");
    assert!(!nodes.iter().any(|node| node.ends_with("/left")), "{nodes:?}");

    // What is saved has the rules, too, and a component that is gone gives its names back.
    let saved = daemon.ctl(&["dump"]);
    assert!(saved.out.contains("position:=/odom"), "{}", saved.out);
    daemon.ctl(&["unload", "left"]).expect_code(0);
    peer.ask(&json!(["no node", "arm", "/base/one"]));
    daemon.ctl(&["load", library, "--name", "left"]).expect_code(0);
    peer.ask(&json!(["service", format!("{namespace}/left/set_speed"), "left", namespace]));
}

#[test]
fn rules_that_cannot_be_kept_are_refused_with_the_way_out() {
    let daemon = Home::new().start(&["--backend", "local"]);
    let library = component("demo").library;
    let load = |rule: &str| daemon.ctl(&["load", path(&library), "--remap", rule]);
    load("positon:=/odom")
        .expect_code(1)
        .expect_err("demo has no out port or service `positon`; did you mean `position`?");
    load("parameter:=/gain").expect_code(1).expect_err(
        "demo: remap: parameter is an in port, which has no name of its own: connect it with \
         [[connection]] in = \"demo/parameter\", out = \"ros2:/gain\"",
    );
    load("position").expect_code(2).expect_err("write `position:=/odom`");
    load("__ns:=lab").expect_code(2).expect_err("a namespace begins with /");
    let body = json!({"library": path(&library), "remap": ["position:=/2"]});
    let refused = request(&daemon.home().socket(), "POST", "/components", &body.to_string());
    assert_eq!(refused.body["error"]["code"], "bad_input", "{}", refused.body);
    assert!(refused.body.to_string().contains("is no name in ROS"), "{}", refused.body);
    load("position:=/odom").expect_code(0);
}
