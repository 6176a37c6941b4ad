//! `[container]`: components that ROS 2 loads, as launch files and `ros2 component load` do
//! (`composition_interfaces`; ROS 2 design, "Composition").

use genom_components::peer::Peer;
use genom_components::ros2;
use genom_tests::{Daemon, Home, component, path, repository};
use serde_json::{Value, json};

/// A daemon with a container, and a node that uses it.
struct World {
    daemon: Daemon,
    peer: Peer,
    namespace: String,
    container: String,
}

const SERVICES: [(&str, &str); 3] =
    [("load_node", "LoadNode"), ("unload_node", "UnloadNode"), ("list_nodes", "ListNodes")];

impl World {
    fn new(more: &str) -> Self {
        let home = Home::new();
        let memory = home.memory();
        let namespace = format!("/{}", memory.prefix().trim_end_matches('_'));
        let of = |package: &str| ros2::types(&repository().join(package)).unwrap();
        let types =
            [of("tests/fixtures/ros2/demo"), of("components/build/ros2/composition_interfaces")];
        let types = std::env::join_paths(types).unwrap();
        let mut node = ros2::node(memory.domain(), Some(types.as_ref())).unwrap();
        let library = component("demo").library;
        let text = format!("[container]\ncomponents = [\"{}\"]\n{more}\n", path(&library));
        let daemon = home.configured(&text).start(&[]);
        let mut peer = Peer::start(&mut node);
        let container = format!("{namespace}/container/_container");
        for (service, ty) in SERVICES {
            let ty = format!("composition_interfaces/srv/{ty}");
            peer.ask(&json!(["client", format!("{container}/{service}"), ty]));
        }
        Self { daemon, peer, namespace, container }
    }

    fn call(&mut self, service: &str, request: &Value) -> Value {
        self.peer.ask(&json!(["call", format!("{}/{service}", self.container), request]))
    }

    fn load(&mut self, request: &Value) -> Value {
        self.call("load_node", request)
    }

    fn list(&mut self) -> Value {
        self.call("list_nodes", &json!({}))
    }

    /// Why a request is refused.
    fn refused(&mut self, request: &Value) -> String {
        let reply = self.load(request);
        assert_eq!(reply["success"], false, "{reply}");
        reply["error_message"].as_str().unwrap().to_owned()
    }
}

fn double(name: &str, value: f64) -> Value {
    json!({"name": name, "value": {"type": 3, "double_value": value}})
}

fn text(name: &str, value: &str) -> Value {
    json!({"name": name, "value": {"type": 4, "string_value": value}})
}

/// Loads the demo with all that a launch file can say, and unloads it.
fn is_loaded_as_asked(extra: &Value) -> World {
    let mut world = World::new("");
    assert_eq!(world.list(), json!({"full_node_names": [], "unique_ids": []}));
    let reply = world.load(&json!({
        "package_name": "demo",
        "plugin_name": "demo",
        "node_name": "arm",
        "node_namespace": "/base",
        "remap_rules": ["position:=/odom", "arm:parameter:=hand/gain"],
        "parameters": [double("velocity", 0.25), {"name": "use_sim_time", "value": {"type": 1}}],
        "extra_arguments": extra,
    }));
    assert_eq!(reply["error_message"], "");
    assert_eq!((&reply["success"], &reply["full_node_name"]), (&json!(true), &json!("/base/arm")));
    let number = reply["unique_id"].as_u64().unwrap();
    assert_eq!(world.list(), json!({"full_node_names": ["/base/arm"], "unique_ids": [number]}));

    // The node is there, by its names, with its parameter; its in port reads what it is to.
    world.peer.ask(&json!(["parameters", "/base/arm"]));
    assert_eq!(world.peer.ask(&json!(["get", "/base/arm", ["velocity"]])), json!([0.25]));
    world.peer.ask(&json!(["read", "/odom", "demo/msg/State"]));
    assert_eq!(world.peer.ask(&json!(["sample", "/odom"]))["position"], 0.0);
    let connections = world.daemon.home().get("/connections");
    let connection = &connections["connections"][0];
    assert_eq!(connection["in"], "arm/parameter", "{connections}");
    assert!(connection["out"].as_str().unwrap().contains("/base/hand/gain"), "{connections}");

    // A second one of the same package: its own number, the name of the component.
    let second = world.load(&json!({"package_name": "demo"}));
    assert_eq!(second["full_node_name"], format!("{}/demo", world.namespace));
    assert_ne!(second["unique_id"], number);

    assert_eq!(world.call("unload_node", &json!({"unique_id": number}))["success"], true);
    world.peer.ask(&json!(["no node", "arm", "/base"]));
    let reply = world.call("unload_node", &json!({"unique_id": number}));
    assert_eq!(reply["success"], false);
    assert_eq!(reply["error_message"], format!("there is no component {number} in this container"));
    world
}

#[test]
fn a_launch_file_loads_a_component_with_name_namespace_parameters_and_remapping() {
    let world = is_loaded_as_asked(&json!([]));
    let told = world.daemon.ctl(&["logs"]).out;
    assert!(told.contains("arm: loaded as /base/arm, as ROS asked"), "{told}");
}

#[test]
fn a_component_is_loaded_into_a_cell_if_the_extra_arguments_say_so() {
    // Arguments that ROS's own containers know have no meaning here.
    let shared =
        json!({"name": "use_intra_process_comms", "value": {"type": 1, "bool_value": true}});
    is_loaded_as_asked(&json!([shared, text("cell", "arm")]));
}

#[test]
fn what_a_container_does_not_load_is_refused_and_nothing_is_left_of_it() {
    let mut world = World::new("most = 1");
    let demo = |more: Value| {
        let mut request = json!({"package_name": "demo"});
        request.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        request
    };
    for (request, told) in [
        (
            json!({"package_name": "dmo"}),
            "package `dmo` is not among those of this container; did you mean `demo`?",
        ),
        (json!({"package_name": "/lib/evil.so"}), "is not among those of this container"),
        (
            demo(json!({"plugin_name": "demo::Talker"})),
            "package `demo` has component `demo`, not `demo::Talker`",
        ),
        (demo(json!({"node_name": "a/b"})), "`a/b` cannot name an instance"),
        (demo(json!({"node_namespace": "2"})), "is no name in ROS"),
        (demo(json!({"remap_rules": ["position"]})), "`position` is no rule"),
        (
            demo(json!({"remap_rules": ["positon:=/odom"]})),
            "demo has no out port or service `positon`",
        ),
        (demo(json!({"remap_rules": ["leg:position:=/odom"]})), "is for node `leg`"),
        (
            demo(json!({"parameters": [double("gain", 1.0)]})),
            "demo has no attribute that sets parameter `gain`",
        ),
        (
            demo(json!({"parameters": [{"name": "velocity", "value": {"type": 0}}]})),
            "parameter `velocity` has no value",
        ),
        (demo(json!({"parameters": [text("velocity", "fast")]})), "velocity"),
        (demo(json!({"parameters": [double("velocity", 99.0)]})), "::demo::OUT_OF_RANGE"),
        (
            demo(
                json!({"parameters": [{"name": "use_sim_time", "value": {"type": 1, "bool_value": true}}]}),
            ),
            "parameter `use_sim_time` = true: the clock of all components is that of the daemon",
        ),
        (demo(json!({"extra_arguments": [double("cell", 1.0)]})), "the name of a cell, a string"),
    ] {
        let why = world.refused(&request);
        assert!(why.contains(told), "{request}: {why}");
    }
    let all = world.daemon.home().get("/components");
    assert_eq!(all["components"], json!([]));
    assert_eq!(world.load(&demo(json!({})))["success"], true);
    assert_eq!(
        world.refused(&demo(json!({"node_name": "other"}))),
        "there are 1 components in this container, the most that it takes"
    );
    // What others unload makes room.
    world.daemon.ctl(&["unload", "demo"]).expect_code(0);
    assert_eq!(world.list()["unique_ids"], json!([]));
    assert_eq!(world.load(&demo(json!({"node_name": "other"})))["success"], true);
}

#[test]
fn many_requests_at_once_load_no_more_than_the_container_takes() {
    let mut world = World::new("most = 3");
    let load = format!("{}/load_node", world.container);
    let replies = world.peer.ask(&json!(["burst", load, 40, {"package_name": "demo"}]));
    // They all want the same name: one has it.
    let done = replies.as_array().unwrap().iter().filter(|reply| reply["success"] == true);
    assert_eq!(done.count(), 1, "{replies}");
    assert_eq!(world.list()["unique_ids"].as_array().unwrap().len(), 1);
}

#[test]
fn an_answer_that_is_longer_than_a_datagram_arrives() {
    let mut world = World::new("");
    for length in [900, 1_300, 1_301, 10_000, 100_000] {
        let rule = "x".repeat(length);
        let why = world.refused(&json!({"package_name": "demo", "remap_rules": [rule]}));
        assert!(why.starts_with(&format!("`{rule}` is no rule")), "{}", why.len());
    }
    let cells = world.daemon.json(&["cells"]);
    assert_eq!(cells["cells"][0]["starts"], 1, "{cells}");
}

#[test]
fn a_daemon_without_the_section_has_no_container() {
    let home = Home::new();
    let mut node = ros2::node(home.memory().domain(), None).unwrap();
    let demo = component("demo");
    let daemon = home.start(&["--backend", "ros2", path(&demo.library)]);
    let mut peer = Peer::start(&mut node);
    let namespace = format!("/{}", home_namespace(&daemon));
    let set = format!("{namespace}/demo/set_speed");
    peer.ask(&json!(["service", set, "demo", namespace]));
    let nodes = peer.ask(&json!(["nodes"])).to_string();
    assert!(!nodes.contains("/container"), "{nodes}");
    let refused = Home::new().configured("[container]\nnode = \"a b\"").refused(&[]);
    refused.expect_code(2).expect_err("container.node = `a b`: use letters, digits and _");
}

fn home_namespace(daemon: &Daemon) -> String {
    daemon.home().memory().prefix().trim_end_matches('_').to_owned()
}
