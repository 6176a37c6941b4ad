//! Daemons on ROS 2 over zenoh, and a node that is no genomd.

use genom_tests::{Daemon, Home, component, path, signal};
use serde_json::{Value, json};

use super::cdr::{Cdr, DIAGNOSTICS, LOAD_NODE, Status, bytes, statuses, text};
use super::zenoh_node::Node;

/// A node, and a daemon that finds it.
struct World {
    daemon: Daemon,
    node: Node,
}

impl World {
    fn new(configuration: &str, arguments: &[&str]) -> Self {
        let node = Node::start();
        // A lease of an hour: that a daemon has ended shows by its connection, or not at all here.
        let by = ["env", "ZENOH_CONFIG_OVERRIDE=transport/link/tx/lease=3600000"];
        let arguments = [&["--backend", "ros2"], arguments].concat();
        let daemon = node.daemon(Home::new().configured(configuration), &by, &arguments);
        Self { daemon, node }
    }

    /// The next status of this name on `/diagnostics`, with this text in it.
    fn diagnosed(&mut self, name: &str, text: &str) -> Status {
        loop {
            let sample = self.node.peer.ask(&json!(["sample", "/diagnostics"]));
            let all = statuses(&bytes(sample["body"].as_str().expect("a body")));
            let wanted = |one: &Status| one.name == name && one.message.contains(text);
            if let Some(found) = all.into_iter().find(wanted) {
                return found;
            }
        }
    }
}

#[test]
fn a_killed_daemon_is_gone_from_ros_at_once_though_a_gateway_had_its_session() {
    let demo = component("demo");
    let World { daemon, mut node } = World::new("", &[path(&demo.library)]);
    node.peer.ask(&json!(["there", "/NN/%/%/demo"]));
    node.peer.ask(&json!(["there", "/MP/%/%/demo/%demo%position/"]));
    let (_, _home) = daemon.stop("KILL");
    node.peer.ask(&json!(["gone", "/%/%/demo"]));
    // The program's own node, too.
    node.peer.ask(&json!(["gone", "genomd"]));
}

#[test]
fn a_component_whose_process_ended_is_an_error_on_diagnostics_until_it_is_back() {
    let demo = component("demo");
    let mut world = World::new("", &["--isolated", path(&demo.library)]);
    let [ty, hash] = DIAGNOSTICS;
    world.node.peer.ask(&json!(["read", "/diagnostics", ty, hash, false]));
    let name = "demo: cell demo";
    assert_eq!(world.diagnosed(name, "").message, "its process runs");
    let cells = world.daemon.home().get("/cells");
    let pid = cells["cells"].as_array().unwrap().iter().find(|cell| cell["name"] == "demo");
    let pid = pid.and_then(|cell| cell["pid"].as_u64()).unwrap_or_else(|| panic!("{cells}"));
    assert!(signal(pid, "KILL"));
    let ended = world.diagnosed(name, "its process ended: signal 9 (SIGKILL); ");
    assert_eq!(ended.level, 2, "ERROR: {ended:?}");
    let back = world.diagnosed(name, "its process runs");
    assert_eq!(back.level, 0, "OK: {back:?}");
    assert_eq!(world.diagnosed("demo: main", "").level & 2, 0, "its tasks are told again");
}

#[test]
fn a_launch_file_loads_a_component_over_zenoh() {
    let demo = component("demo");
    let container = format!("[container]\ncomponents = [{:?}]\n", path(&demo.library));
    let World { daemon, mut node } = World::new(&container, &[]);
    let [ty, hash] = LOAD_NODE;
    let service = "/container/_container/load_node";
    node.peer.ask(&json!(["client", service, ty, hash]));
    // Package, plugin, name and namespace of the node; what fills the last one up to a multiple of 4
    // is the level of its log, too. No rules, parameters or extra arguments.
    let names = ["demo", "demo", "arm", "/base"].map(text).concat();
    let request = format!("00010000{names}{}", "00000000".repeat(3));
    let reply = node.peer.ask(&json!(["call", service, request]));
    let body = bytes(reply["body"].as_str().unwrap_or_else(|| panic!("{reply}")));
    let mut reply = Cdr { all: &body[4..], at: 0 };
    assert_eq!((reply.octet(), reply.text()), (1, String::new()), "no error");
    assert_eq!(reply.text(), "/base/arm");
    node.peer.ask(&json!(["there", "/NN/%/%base/arm"]));
    let components: Value = daemon.home().get("/components");
    assert_eq!(components["components"][0]["name"], "arm", "{components}");
}
