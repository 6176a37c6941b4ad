//! Daemons on ROS 2 over zenoh, and a node that is no genomd.

use genom_tests::{Daemon, Home, component, path, signal};
use serde_json::{Value, json};

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

fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks(2);
    digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap()).collect()
}

/// `diagnostic_msgs/msg/DiagnosticStatus`, but for its values.
#[derive(Debug)]
struct Status {
    level: u8,
    name: String,
    message: String,
}

/// Little-endian CDR, version 1, read from its start (OMG DDS-XTypes 1.3, 7.4.1).
struct Cdr<'a> {
    all: &'a [u8],
    at: usize,
}

impl Cdr<'_> {
    fn number(&mut self) -> u32 {
        self.at = self.at.next_multiple_of(4);
        let four = self.all[self.at..self.at + 4].try_into().unwrap();
        self.at += 4;
        u32::from_le_bytes(four)
    }

    fn octet(&mut self) -> u8 {
        self.at += 1;
        self.all[self.at - 1]
    }

    /// Its length counts the zero at its end.
    fn text(&mut self) -> String {
        let length = self.number() as usize;
        let text = &self.all[self.at..self.at + length - 1];
        self.at += length;
        String::from_utf8(text.to_vec()).unwrap()
    }
}

/// A `diagnostic_msgs/msg/DiagnosticArray`.
fn statuses(body: &[u8]) -> Vec<Status> {
    assert_eq!(body[..4], [0, 1, 0, 0]);
    let mut cdr = Cdr { all: &body[4..], at: 0 };
    let _date = (cdr.number(), cdr.number());
    let _frame = cdr.text();
    let count = cdr.number();
    let status = |_| {
        let level = cdr.octet();
        let (name, message, _hardware) = (cdr.text(), cdr.text(), cdr.text());
        for _ in 0..cdr.number() {
            let _value = (cdr.text(), cdr.text());
        }
        Status { level, name, message }
    };
    (0..count).map(status).collect()
}

/// Text in hexadecimal CDR that begins on a multiple of 4, and ends on one.
fn text(text: &str) -> String {
    let mut all = (text.len() as u32 + 1).to_le_bytes().to_vec();
    all.extend(text.bytes().chain([0]));
    all.resize(all.len().next_multiple_of(4), 0);
    all.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A type as a key has it, and its hash as ROS 2 Jazzy publishes it.
const DIAGNOSTICS: [&str; 2] = [
    "diagnostic_msgs::msg::dds_::DiagnosticArray_",
    "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
];
const LOAD_NODE: [&str; 2] = [
    "composition_interfaces::srv::dds_::LoadNode_",
    "RIHS01_2e521ef6066fba6d7fc3a3b175d486709f01b4d738d9a59188858546fc8e5acd",
];

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
    // Package, plugin, name and namespace of the node; level of its log; no rules, parameters or
    // extra arguments.
    let names = ["demo", "demo", "arm", "/base"].map(text).concat();
    let request = format!("00010000{names}{}", "00000000".repeat(4));
    let reply = node.peer.ask(&json!(["call", service, request]));
    let body = bytes(reply["body"].as_str().unwrap_or_else(|| panic!("{reply}")));
    let mut reply = Cdr { all: &body[4..], at: 0 };
    assert_eq!((reply.octet(), reply.text()), (1, String::new()), "no error");
    assert_eq!(reply.text(), "/base/arm");
    node.peer.ask(&json!(["there", "/NN/%/%base/arm"]));
    let components: Value = daemon.home().get("/components");
    assert_eq!(components["components"][0]["name"], "arm", "{components}");
}
