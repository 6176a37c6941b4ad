//! What a daemon tells hiroz without being asked: its log, its state, types that it describes.

use genom_tests::{Daemon, signal, until};
use serde_json::json;

use super::super::cdr::{Cdr, DIAGNOSTICS, LOG, Status, bytes, statuses};
use super::daemons::World;

/// `rcl_interfaces/msg/Log`, but for its date and its place.
#[derive(Debug, PartialEq)]
struct Entry {
    level: u8,
    logger: String,
    message: String,
}

impl World {
    fn body(&mut self, topic: &str) -> Vec<u8> {
        let sample = self.peer.ask(&json!(["sample", topic]));
        bytes(sample.as_str().expect("a message"))
    }

    /// The next entry of the log that begins so.
    fn logged(&mut self, begins: &str) -> Entry {
        loop {
            let body = self.body("/rosout");
            let mut cdr = Cdr { all: &body[4..], at: 0 };
            let _date = (cdr.number(), cdr.number());
            let (level, logger, message) = (cdr.octet(), cdr.text(), cdr.text());
            if message.starts_with(begins) {
                return Entry { level, logger, message };
            }
        }
    }

    /// The next status of this name on `/diagnostics`, with this text in it.
    fn diagnosed(&mut self, name: &str, text: &str) -> Status {
        loop {
            let all = statuses(&self.body("/diagnostics"));
            let wanted = |one: &Status| one.name == name && one.message.contains(text);
            if let Some(found) = all.into_iter().find(wanted) {
                return found;
            }
        }
    }
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_reads_on_rosout_what_a_component_logged_before_and_what_it_logs_then() {
    let mut world = World::demo(&[]);
    let [ty, hash] = LOG;
    world.peer.ask(&json!(["read", "/rosout", ty, hash, true]));
    let logger = format!("{}.demo", world.namespace.trim_start_matches('/'));
    // INFO.
    let ready = Entry { level: 20, logger, message: "runs on ros2".to_owned() };
    assert_eq!(world.logged("runs on "), ready, "though it came late");
    world.daemon.ctl(&["reload", "demo"]).expect_code(0);
    let again = world.logged("runs /");
    assert_eq!((again.level, &again.logger), (20, &ready.logger));
}

fn pid_of_cell(daemon: &Daemon) -> u64 {
    let cells = daemon.home().get("/cells");
    let cell = cells["cells"].as_array().unwrap().iter().find(|cell| cell["name"] == "demo");
    cell.and_then(|cell| cell["pid"].as_u64()).unwrap_or_else(|| panic!("{cells}"))
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_reads_on_diagnostics_that_a_process_ended_and_that_it_is_back() {
    let mut world = World::demo(&["--isolated"]);
    let [ty, hash] = DIAGNOSTICS;
    world.peer.ask(&json!(["read", "/diagnostics", ty, hash]));
    let name = "demo: cell demo";
    assert_eq!(world.diagnosed(name, "").message, "its process runs");
    assert!(signal(pid_of_cell(&world.daemon), "KILL"));
    let ended = world.diagnosed(name, "its process ended: signal 9 (SIGKILL); ");
    assert_eq!(ended.level, 2, "ERROR: {ended:?}");
    let back = world.diagnosed(name, "its process runs");
    assert_eq!(back.level, 0, "OK: {back:?}");
}

#[test]
#[ignore = "hiroz takes minutes to compile: .ci/release runs it"]
fn hiroz_reads_a_type_of_a_component_in_a_cell_by_the_description_that_its_node_gives() {
    let mut world = World::demo(&["--isolated"]);
    let position = world.of_demo("position");
    let World { daemon, peer, .. } = &mut world;
    let told = peer.ask(&json!(["learn", position]));
    assert_eq!(told["type"], "demo/msg/State");
    assert_eq!(told["told"], told["hash"], "hiroz computes the same hash of it");
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    // Nobody tells when the daemon knows the reader.
    let mut thousandths = 0;
    until("it is connected", || {
        thousandths += 1;
        let goal = format!("goal={}", f64::from(thousandths) / 1000.0);
        daemon.ctl(&["call", "demo", "goto", &goal]).expect_code(0);
        !peer.ask(&json!(["any learned", position])).is_null()
    });
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    loop {
        let sample = peer.ask(&json!(["learned", position]));
        let members: Vec<&String> = sample.as_object().unwrap().keys().collect();
        assert_eq!(members, ["position", "velocity"]);
        let speed = sample["velocity"].as_f64().unwrap();
        assert!((0.0..=2.0).contains(&speed), "{sample}");
        if sample["position"] == 0.5 {
            break;
        }
    }
}
