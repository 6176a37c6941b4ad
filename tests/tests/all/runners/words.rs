//! The example of a runner (`tests/fixtures/words`): codels in a language of its own do what those in C
//! do, with nothing but what docs/runners.md tells.

use std::fs;

use genom_tests::{Daemon, path};
use serde_json::{Value, json};

use super::{example, home, toy};

/// A daemon with the component of the example.
fn started(options: &[&str]) -> Daemon {
    let file = example("toy.gen");
    home(&example("runner.py")).start(&[options, &[path(&file)]].concat())
}

/// What the component published last.
fn place(daemon: &Daemon) -> Value {
    daemon.port("toy", "where")["value"].clone()
}

#[track_caller]
fn codels_use_ids_ports_parameters_events_and_exceptions(backend: &str) {
    let daemon = started(&["--backend", backend]);
    // Between processes, what would stay in one goes over shared memory.
    let between = if backend == "local" { "shm" } else { backend };
    assert_eq!(daemon.port("toy", "where")["backend"], between);
    assert_eq!(place(&daemon), json!({"position": 0.0, "steps": 0, "moves": false}));

    // Nothing was published for `pace`: steps are of 0.25 m.
    let mut events = daemon.events();
    daemon.ctl(&["call", "toy", "go", "goal=1"]).expect_code(0).expect_out("done\n");
    let told = events.until(|event| event["event"] == "activity_ended");
    let states = told.iter().filter(|event| event["event"] == "transition");
    let mut states: Vec<&str> = states.map(|event| event["state"].as_str().unwrap()).collect();
    states.dedup();
    assert_eq!(states, ["main", "arrived"], "{told:?}");
    assert_eq!(place(&daemon), json!({"position": 1.0, "steps": 4, "moves": false}));

    daemon.ctl(&["pub", "toy/pace", "0.5"]).expect_code(0);
    daemon.ctl(&["call", "toy", "go", "goal=2"]).expect_code(0);
    assert_eq!(place(&daemon)["steps"], 6);
    // An output is stored by its address, a boolean comes by value.
    let tell = |twice: &str| daemon.json(&["call", "toy", "tell", twice])["result"].clone();
    assert_eq!(tell("twice=false"), json!({"far": 2.0, "steps": 6}));
    assert_eq!(tell("twice=true"), json!({"far": 4.0, "steps": 6}));

    // What control stored is seen by codels; the exception comes with its detail.
    daemon.ctl(&["call", "toy", "set_most", "most=3.5"]).expect_code(0);
    let refused = daemon.ctl(&["call", "toy", "go", "goal=4"]);
    refused.expect_code(1).expect_err("toy/go ended with ::toy::TOO_FAR");
    refused.expect_err(r#"{"asked":4.0,"most":3.5,"unit":"m"}"#);
    assert_eq!(place(&daemon)["steps"], 6, "nothing moved");

    // An activity that is interrupted runs its stop codel.
    daemon.ctl(&["pub", "toy/pace", "1e-9"]).expect_code(0);
    // A new stream: the first one has the events of the motions before.
    let mut events = daemon.events();
    daemon.ctl(&["start", "toy", "go", "goal=3"]).expect_code(0);
    events.wait_for(|event| event["state"] == "main" && event["paused"] == true);
    daemon.ctl(&["abort", "toy", "go"]).expect_code(0);
    events.wait_for(|event| event["event"] == "activity_ended");
    let stopped = place(&daemon);
    assert_eq!(stopped["moves"], false);
    assert!(stopped["position"].as_f64().unwrap() < 2.1, "{stopped}");
}

#[test]
fn codels_use_ids_ports_parameters_events_and_exceptions_on_local() {
    codels_use_ids_ports_parameters_events_and_exceptions("local");
}

#[test]
fn codels_use_ids_ports_parameters_events_and_exceptions_on_shared_memory() {
    codels_use_ids_ports_parameters_events_and_exceptions("shm");
}

#[test]
fn codels_use_ids_ports_parameters_events_and_exceptions_on_zenoh() {
    codels_use_ids_ports_parameters_events_and_exceptions("zenoh");
}

#[test]
fn codels_use_ids_ports_parameters_events_and_exceptions_on_ros_2() {
    codels_use_ids_ports_parameters_events_and_exceptions("ros2");
}

/// The component of the example with another script.
fn changed(from: &str, to: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let script = fs::read_to_string(example("toy.words")).unwrap();
    assert_eq!(script.matches(from).count(), 1, "{from}");
    let description = fs::read_to_string(example("toy.gen")).unwrap();
    toy(&description, &script.replace(from, to))
}

#[test]
fn an_error_of_the_language_ends_the_service_and_is_told_with_its_line() {
    let (_scratch, file) = changed("far = now.position\n", "far = now.position / 0\n");
    let daemon = home(&example("runner.py")).start(&[path(&file)]);
    let wrong = daemon.ctl(&["call", "toy", "tell", "twice=false"]);
    wrong.expect_code(1).expect_err("::genom::unkex");
    let told = "toy_tell, line 17: float division by zero";
    wrong.expect_err(told);
    assert!(daemon.process().error_line_where(|line| line.contains(told)).is_some());
    daemon.ctl(&["call", "toy", "go", "goal=1"]).expect_code(0);
}

#[test]
fn all_mistakes_of_a_script_are_told_with_their_lines() {
    let (_scratch, file) = changed("  far = now.position\n", "  far = now.place\n  yield ether\n");
    let refused = home(&example("runner.py")).refused(&[path(&file)]);
    refused.expect_code(1).expect_err("line 17: codel toy_tell: ");
    refused.expect_err("has no member place").expect_err("line 18: codel toy_tell: `yield ether`");
}

#[test]
fn a_codel_that_does_not_return_is_told_with_the_line_where_it_is() {
    let daemon = started(&["--set", "stuck_after=1"]);
    daemon.ctl(&["start", "toy", "spin"]).expect_code(0);
    let told = |line: &str| line.contains("toy.words: codel toy_spin is at line 5");
    assert!(daemon.process().error_line_where(told).is_some());
    daemon.ctl(&["call", "toy", "tell", "twice=false"]).expect_code(0);
}

#[test]
fn a_runner_for_another_version_says_so_and_is_not_tried_again() {
    let scratch = tempfile::tempdir().unwrap();
    let runner = scratch.path().join("runner.py");
    let text = fs::read_to_string(example("runner.py")).unwrap();
    let version = format!("VERSION = \"{}\"", env!("CARGO_PKG_VERSION"));
    assert_eq!(text.matches(&version).count(), 1, "{version}");
    fs::write(&runner, text.replace(&version, "VERSION = \"0.0.9\"")).unwrap();
    let refused = home(&runner).refused(&[path(&example("toy.gen"))]);
    refused.expect_code(1).expect_err("a runner for genomd 0.0.9, not for ");
    assert!(!refused.err.contains("restarted in"), "{}", refused.err);
}

#[test]
fn the_whole_runner_has_three_hundred_lines_at_most() {
    let lines = fs::read_to_string(example("runner.py")).unwrap().lines().count();
    assert!(lines <= 300, "{lines}");
}
