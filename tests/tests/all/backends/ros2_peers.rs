//! Genuine ROS 2 Jazzy nodes together with a daemon that runs the demo. The nodes use the demo's
//! own types, built with ROS's code generators as users do.
//!
//! A peer replies to a command when ROS reports that the other end exists, so no test assumes that
//! discovery has finished.

use genom_components::peer::Peer;
use genom_components::ros2;
use genom_tests::{Daemon, Home, component, path, repository, until};
use serde_json::{Value, json};

/// The demo on ROS 2, in a namespace of its own, and a ROS node.
struct World {
    daemon: Daemon,
    peer: Peer,
    namespace: String,
}

impl World {
    fn new() -> Self {
        Self::with(&[])
    }

    fn with(options: &[&str]) -> Self {
        let home = Home::new();
        let memory = home.memory();
        let namespace = format!("/{}", memory.prefix().trim_end_matches('_'));
        let types = ros2::types(&repository().join("tests/fixtures/ros2/demo")).unwrap();
        let mut node = ros2::node(memory.domain(), Some(&types)).unwrap();
        let demo = component("demo");
        let daemon =
            home.start(&[&["--backend", "ros2"], options, &[path(&demo.library)]].concat());
        Self { daemon, peer: Peer::start(&mut node), namespace }
    }
}

#[test]
fn a_ros_node_reads_calls_and_sets_the_demo() {
    let World { daemon, mut peer, namespace } = World::new();
    let name = |of: &str| format!("{namespace}/demo/{of}");
    peer.ask(&json!(["read", name("position"), "demo/msg/State"]));
    let rest = json!({"position": 0.0, "velocity": 0.0});
    assert_eq!(peer.ask(&json!(["sample", name("position")])), rest);

    // A service and its exception.
    peer.ask(&json!(["client", name("set_speed"), "demo/srv/SetSpeed"]));
    let set = |velocity: f64| json!(["call", name("set_speed"), {"velocity": velocity}]);
    let done = json!({"genom_exception": "", "genom_detail": ""});
    assert_eq!(peer.ask(&set(2.0)), done);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 2.0\n");
    let refused = peer.ask(&set(9.0));
    assert_eq!(refused["genom_exception"], "::demo::OUT_OF_RANGE");
    let detail: Value = serde_json::from_str(refused["genom_detail"].as_str().unwrap()).unwrap();
    assert_eq!(detail["value"], 9.0);

    // The same attribute as a parameter.
    let node = format!("{namespace}/demo");
    peer.ask(&json!(["parameters", node]));
    assert_eq!(peer.ask(&json!(["list", node]))["names"], json!(["use_sim_time", "velocity"]));
    assert_eq!(peer.ask(&json!(["get", node, ["velocity"]])), json!([2.0]));
    let results = peer.ask(&json!(["set", node, [["velocity", 1.5], ["velocity", 9.0]]]));
    assert_eq!(results[0]["successful"], true);
    assert_eq!(results[1]["successful"], false);
    let reason = results[1]["reason"].as_str().unwrap();
    assert!(reason.starts_with("::demo::OUT_OF_RANGE {"), "{reason}");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 1.5\n");

    // What ROS shows of the node.
    let types = peer.ask(&json!(["service", name("set_speed"), "demo", namespace]));
    assert_eq!(types, json!(["demo/srv/SetSpeed"]));
    let topics = peer.ask(&json!(["topics"]));
    assert_eq!(topics[name("position")], json!(["demo/msg/State"]));
    assert_eq!(topics[name("goto/_action/feedback")], json!(["demo/action/Goto_FeedbackMessage"]));

    // A topic of a ROS node, connected to a port.
    daemon.ctl(&["connect", "demo/parameter", "ros2:/hand/gain"]).expect_code(0);
    peer.ask(&json!(["write", "/hand/gain", "std_msgs/msg/Float64"]));
    peer.ask(&json!(["put", "/hand/gain", {"data": 0.25}]));
    // The port is read only during a motion; this one is slow enough to last.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let echo = daemon.spawn(&["echo", "demo/parameter"]);
    echo.line_where(|line| line == "0.25");
}

/// All that a node says of a type, which it finds by hash if there is one, or else by name.
fn described(peer: &mut Peer, node: &str, name: &str, hash: &str) -> Value {
    let asked = json!({"type_name": name, "type_hash": hash, "include_type_sources": true});
    let mut told = peer.ask(&json!(["call", format!("{node}/get_type_description"), asked]));
    assert_eq!(told["successful"], true, "{name}: {told}");
    // Comments are not compared.
    for source in told["type_sources"].as_array_mut().expect("texts") {
        let text = source["raw_file_contents"].take();
        if source["type_name"].as_str().is_some_and(|name| name.starts_with("demo/")) {
            let lines = text.as_str().expect("a text").lines();
            let lines = lines.map(|line| line.split('#').next().unwrap_or_default().trim_end());
            let lines: Vec<_> = lines.filter(|line| !line.is_empty()).collect();
            source["raw_file_contents"] = lines.into();
        }
    }
    told
}

#[test]
fn a_component_in_a_cell_describes_its_types_as_a_ros_node_that_has_them_in_its_packages() {
    let World { daemon: _daemon, mut peer, namespace } = World::with(&["--isolated"]);
    let name = |of: &str| format!("{namespace}/demo/{of}");
    peer.ask(&json!(["read", name("position"), "demo/msg/State"]));
    peer.ask(&json!(["client", name("set_speed"), "demo/srv/SetSpeed"]));
    peer.ask(&json!(["action", name("goto"), "demo/action/Goto"]));
    let ours = format!("{namespace}/demo");
    for node in [&ours, "/peer"] {
        let service = format!("{node}/get_type_description");
        let ty = "type_description_interfaces/srv/GetTypeDescription";
        peer.ask(&json!(["client", service, ty]));
    }
    for ty in ["demo/msg/State", "demo/srv/SetSpeed", "demo/action/Goto"] {
        let mut told = described(&mut peer, &ours, ty, "");
        let hash = told["extra_information"].take();
        let hash = hash[0]["value"].as_str().expect("its hash");
        let mut theirs = described(&mut peer, "/peer", ty, hash);
        assert_eq!(theirs["extra_information"].take(), json!([]));
        // Of types in packages ROS gives the text in IDL that it made of the message.
        let texts = [told["type_sources"].take(), theirs["type_sources"].take()];
        assert_eq!(told, theirs, "{ty}");
        if ty == "demo/msg/State" {
            let text = ["float64 position", "float64 velocity"];
            let ours = json!({"type_name": ty, "encoding": "msg", "raw_file_contents": text});
            assert_eq!(texts[0], json!([ours]));
            assert_eq!(texts[1][0]["type_name"], ty, "{texts:?}");
        }
    }
}

#[test]
fn what_the_demo_logs_how_its_task_fares_and_which_parameters_are_set_is_told_to_all_nodes() {
    let World { daemon, mut peer, namespace } = World::new();
    let node = format!("{namespace}/demo");
    // As rqt_console reads it: whoever comes late gets the latest entry.
    peer.ask(&json!(["read", "/rosout", "rcl_interfaces/msg/Log", 1, true]));
    let entry = peer.ask(&json!(["sample", "/rosout"]));
    assert_eq!(entry["msg"], "runs on ros2");
    assert_eq!(
        (&entry["level"], &entry["function"]),
        (&json!(20), &json!("genom_supervisor::supervisor"))
    );
    let file = entry["file"].as_str().unwrap();
    assert!(file.ends_with("supervisor/src/supervisor.rs"), "{file}");
    let line = entry["line"].as_u64().unwrap() as usize;
    let source = std::fs::read_to_string(repository().join(file)).unwrap();
    let logs = source.lines().skip(line - 1).take(4).any(|line| line.contains("runs on"));
    assert!(logs, "line {line} of {file}");
    assert_eq!(entry["name"], format!("{}.demo", namespace.trim_start_matches('/')));
    daemon.ctl(&["reload", "demo"]).expect_code(0);
    while !peer.ask(&json!(["sample", "/rosout"]))["msg"].as_str().unwrap().starts_with("runs /") {}

    peer.ask(&json!(["read", "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"]));
    let told = peer.ask(&json!(["sample", "/diagnostics"]));
    let status = &told["status"][0];
    assert_eq!(status["name"], "demo: main");
    // 0 OK, 1 WARN: this machine may have made it miss a period.
    assert!(status["level"].as_u64().unwrap() < 2, "{status}");
    assert_eq!(status["values"][0]["key"], "missed periods");

    // The node that listens is a publisher, too.
    peer.ask(&json!(["read", "/parameter_events", "rcl_interfaces/msg/ParameterEvent", 2]));
    peer.ask(&json!(["parameters", node]));
    peer.ask(&json!(["set", node, [["velocity", 1.5], ["velocity", 9.0]]]));
    let event = peer.ask(&json!(["sample", "/parameter_events"]));
    assert_eq!(event["node"], json!(node));
    let changed = event["changed_parameters"].as_array().unwrap();
    // The second one was refused.
    assert_eq!(changed.len(), 1, "{event}");
    assert_eq!(changed[0]["name"], "velocity");
    assert_eq!(changed[0]["value"]["double_value"], 1.5);
}

#[test]
fn a_ros_node_sends_the_demo_goals_and_gives_them_up() {
    let World { daemon, mut peer, namespace } = World::new();
    let goto = format!("{namespace}/demo/goto");
    let goal = |goal: f64| json!(["goal", goto, {"goal": goal}]);
    let feed = json!(["feedback", goto]);
    let result = json!(["result", goto]);
    let ended = |status: &str, exception: &str, detail: &str| {
        let result = json!({"genom_exception": exception, "genom_detail": detail});
        json!({"status": status, "result": result})
    };
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    peer.ask(&json!(["action", goto, "demo/action/Goto"]));
    assert_eq!(peer.ask(&goal(0.01)), json!(true));
    assert_eq!(peer.ask(&result), ended("SUCCEEDED", "", ""));
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.01);

    // With a gain of 0 it never arrives.
    daemon.ctl(&["pub", "demo/parameter", "0"]).expect_code(0);
    assert_eq!(peer.ask(&goal(1.0)), json!(true));
    // Short states may be missed; this one lasts.
    while peer.ask(&feed) != json!({"genom_state": "main"}) {}
    peer.ask(&json!(["status", goto, "EXECUTING"]));
    assert_eq!(peer.ask(&json!(["cancel", goto])), json!({"code": 0, "goals": 1}));
    // It braked and stopped, as described.
    assert_eq!(peer.ask(&result), ended("CANCELED", "", ""));
    peer.ask(&json!(["status", goto, "CANCELED"]));
    // It has ended, so there is nothing to cancel.
    assert_eq!(peer.ask(&json!(["cancel", goto])), json!({"code": 3, "goals": 0}));

    // A goal that the component refuses ends with its exception.
    assert_eq!(peer.ask(&goal(99.0)), json!(true));
    let refused = peer.ask(&result);
    assert_eq!(refused["status"], "ABORTED");
    assert_eq!(refused["result"]["genom_exception"], "::demo::OUT_OF_RANGE");
}

/// `#pragma masquerade ros2` of `components/images`.
#[test]
fn a_ros_node_finds_the_images_of_the_camera_as_images_of_ros() {
    let home = Home::new();
    let memory = home.memory();
    let name = format!("/{}/camera/left", memory.prefix().trim_end_matches('_'));
    let mut node = ros2::node(memory.domain(), None).unwrap();
    let camera = component("camera");
    let _daemon = home.start(&["--backend", "ros2", path(&camera.library)]);
    let mut peer = Peer::start(&mut node);
    until("the topic is listed", || {
        peer.ask(&json!(["topics"]))[&name] == json!(["sensor_msgs/msg/Image"])
    });
}

#[test]
fn the_doctor_names_a_node_that_nobody_finds() {
    let home = Home::new();
    let mut node = ros2::node(home.memory().domain(), None).unwrap();
    let mut peer = Peer::start(node.env("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"));
    peer.ask(&json!(["nodes"]));
    let demo = component("demo");
    let daemon = home.start(&["--backend", "ros2", path(&demo.library)]);
    let told = daemon.ctl(&["doctor"]).out;
    assert!(told.contains("has ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: nobody finds it"), "{told}");
    assert!(
        told.contains(&format!("domain {} over dds", daemon.home().memory().domain())),
        "{told}"
    );
}
