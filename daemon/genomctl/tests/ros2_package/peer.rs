//! ROS's own parser reads the packages, and `rosbags` reads and writes what our CDR code does.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use genom_description::{Options, read_text};
use genom_rosidl::{Library, TypeName};
use genom_types::{DataType, Record};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::EVERYTHING;
use crate::support::Room;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(120);

#[derive(Deserialize)]
struct Known {
    interfaces: Vec<String>,
    hashes: BTreeMap<String, String>,
    /// Definitions of ROS's standard messages.
    standard: BTreeMap<String, String>,
}

#[derive(Deserialize)]
struct Answer {
    value: Value,
    cdr: String,
}

struct Peer {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
}

impl Peer {
    fn start(packages: &std::path::Path) -> Self {
        let python = genom_components::python::environment(&[
            "rosbags==0.11.9",
            "ros-rosidl-adapter==4.6.6",
        ])
        .unwrap_or_else(|error| panic!("the peer in Python cannot be had: {error}"));
        let mut child = Command::new(python)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/ros2_package/peer.py"))
            .arg(packages)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = channel();
        let output = BufReader::new(child.stdout.take().unwrap());
        thread::spawn(move || {
            output.lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        let input = child.stdin.take().unwrap();
        Self { child, input, lines }
    }

    #[track_caller]
    fn says<T: for<'de> Deserialize<'de>>(&self) -> T {
        let line = self.lines.recv_timeout(WATCHDOG).expect("the peer answers");
        serde_json::from_str(&line).unwrap()
    }

    fn ask(&mut self, ty: &str, message: &[u8]) -> Answer {
        let asked = json!({"type": ty, "cdr": hex(message)});
        writeln!(self.input, "{asked}").unwrap();
        self.says()
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let pairs = text.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap());
    pairs.map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect()
}

#[test]
fn ros_reads_the_packages_and_the_messages() {
    let room = Room::new(&[("robot.gen", EVERYTHING)]);
    let (code, out, err) = room.run("ros2-package --json robot.gen src", "");
    assert_eq!(code, 0, "{err}");
    let told: Value = serde_json::from_str(&out).unwrap();
    let ours: BTreeMap<String, String> =
        serde_json::from_value(told["interfaces"].clone()).unwrap();
    let mut peer = Peer::start(&room.path("src"));
    let known: Known = peer.says();
    assert_eq!(known.interfaces, ours.keys().cloned().collect::<Vec<_>>());
    assert!(known.hashes.len() > 10, "{:?}", known.hashes);
    for (name, hash) in &known.hashes {
        assert_eq!(&ours[name], hash, "{name}");
    }

    check_standard(&known.standard);

    let analysis = read_text("robot.gen", EVERYTHING, &Options::default());
    let specification = &analysis.specification;
    let component = &specification.components[0];
    let port = |name: &str| {
        let port = component.ports.iter().find(|port| port.name == name).unwrap();
        DataType::new(&specification.types, port.ty).unwrap()
    };
    let service = component.services.iter().find(|service| service.name == "walk").unwrap();
    let goal = DataType::new(&specification.types, service.input).unwrap();
    for (ty, ros, given, expected) in [
        (port("full"), "robot/msg/State", full(), full_in_ros()),
        (
            port("scan"),
            "geo/msg/Cloud",
            json!([{"x": 1.5, "y": -2.0}, {"x": 0.0, "y": 3.0}]),
            json!({"data": [{"x": 1.5, "y": -2.0}, {"x": 0.0, "y": 3.0}]}),
        ),
        (port("what"), "robot/msg/ModeT", json!("at_rest"), json!({"data": 2})),
        (port("waypoint"), "geo/msg/Point", json!({"x": 7.0}), json!({"x": 7.0, "y": 0.0})),
        (
            goal,
            "robot/msg/Walk_Goal",
            json!({"goal": {"x": 1.0, "y": 2.0}, "laps": -3}),
            json!({"goal": {"x": 1.0, "y": 2.0}, "laps": -3}),
        ),
    ] {
        let mut record = Record::new(&ty);
        record.merge_json(&given).unwrap();
        let mut message = Vec::new();
        record.encode_message(&mut message).unwrap();
        let answer = peer.ask(ros, &message);
        assert_eq!(answer.value, expected, "{ros}");
        let again = unhex(&answer.cdr);
        assert_eq!(again[1], 0, "it comes back big endian");
        let mut decoded = Record::new(&ty);
        decoded.decode_message(&again).unwrap();
        assert_eq!(decoded.to_json(), record.to_json(), "{ros}");
    }
}

/// The built-in definitions of ROS's standard messages are those of ROS.
#[track_caller]
fn check_standard(published: &BTreeMap<String, String>) {
    let library = Library::default();
    let find = |name: &TypeName| library.message(name).ok();
    let mut compared = 0;
    for (name, hash) in published {
        let Ok(interface) = library.find(&TypeName::parse(name).unwrap()) else { continue };
        assert_eq!(&genom_rosidl::hash(&interface, &find).unwrap(), hash, "{name}");
        compared += 1;
    }
    assert!(compared > 100, "{compared} messages");
}

fn full() -> Value {
    json!({
        "all": {
            "yes": true, "letter": "A", "byte": 200, "a": -300, "b": 60000, "c": -70000,
            "d": 4_000_000_000_u32, "e": -5_000_000_000_i64, "f": 18_000_000_000_000_000_000_u64,
            "g": 0.5, "h": 1.0e300,
        },
        "name": "né à Toulouse",
        "tag": "1234567",
        "tags": ["abc", ""],
        "now": "Moving",
        "paint": ["green", "RED", "green"],
        "rotation": [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]],
        "seen": [{"x": 0.25, "y": 8.0}],
        "rows": [[1, 2, 3], [-4]],
        "stack": [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]],
        "maybe": 17,
        "perhaps": [{"x": 1.0, "y": 1.0}, {"x": 2.0, "y": 2.0}],
        "last": {"d": "Moving", "u": {"target": {"x": 9.0, "y": 10.0}}},
        "Kp": 0.125,
    })
}

/// The expected value in ROS, according to the table of the mapping.
fn full_in_ros() -> Value {
    json!({
        "all": {
            "yes": true, "letter": 65, "byte": 200, "a": -300, "b": 60000, "c": -70000,
            "d": 4_000_000_000_u32, "e": -5_000_000_000_i64, "f": 18_000_000_000_000_000_000_u64,
            "g": 0.5, "h": 1.0e300,
        },
        "name": "né à Toulouse",
        "tag": "1234567",
        "tags": ["abc", ""],
        "now": 1,
        "paint": [1, 0, 1],
        "rotation": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        "seen": [{"x": 0.25, "y": 8.0}],
        "rows": [{"data": [1, 2, 3]}, {"data": [-4]}],
        "stack": [{"data": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]}],
        "maybe": [17],
        "perhaps": [{"data": [{"x": 1.0, "y": 1.0}, {"x": 2.0, "y": 2.0}]}],
        "last": {
            "genom_discriminant": 1, "pause": [], "target": [{"x": 9.0, "y": 10.0}], "raw": [],
        },
        "kp": 0.125,
    })
}
