//! The demo with codels in C++ (`lang "c++"`, genom3.md 6), used through genomd and genomctl.

use std::fs;
use std::process::Command;

use genom_tests::{Daemon, Home, Running, component, path, program, repository};
use serde_json::{Value, json};

fn start(backend: &str) -> Daemon {
    Daemon::start(&["--backend", backend, path(&component("demo-cpp").library)])
}

/// The last value of a port.
fn value(daemon: &Daemon, port: &str) -> Value {
    daemon.port("demo", port)["value"].clone()
}

/// The same requests as in the test of the demo in C.
#[track_caller]
fn the_session_of_the_demo_in_c(backend: &str) {
    let daemon = start(backend);
    let position = || value(&daemon, "position")["position"].clone();
    daemon.ctl(&["call", "demo", "set_speed", r#"{"velocity":2.0}"#]).expect_code(0);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0).expect_out("velocity = 2.0\n");
    daemon.ctl(&["start", "--wait", "demo", "goto", r#"{"goal":0.5}"#]).expect_code(0);
    assert_eq!(position(), 0.5);
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0).expect_out("done\n");
    assert_eq!(position(), 0.25);
    daemon.ctl(&["call", "demo", "reset"]).expect_code(0);

    let refused = daemon.ctl(&["start", "demo", "goto", "goal=50"]);
    refused.expect_code(1).expect_out("");
    refused.expect_err("demo/goto ended with ::demo::OUT_OF_RANGE");
    refused.expect_err(r#"{"value":50.0,"lower":-10.0,"upper":10.0,"what":"goal, m"}"#);
    let refused = daemon.ctl(&["--json", "call", "demo", "set_speed", "velocity=9"]);
    refused.expect_code(1);
    let reply: Value = serde_json::from_str(&refused.out).unwrap();
    assert_eq!(reply["exception"], "::demo::OUT_OF_RANGE");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 2.0\n");

    // So slow that a motion lasts as long as the test needs.
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.1"]).expect_code(0);
    let moving = || {
        // A new stream each time: the old one may still contain events of the previous motion.
        let mut events = daemon.events();
        let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
        events.wait_for(|e| e["state"] == "main" && e["paused"] == true);
        waiting
    };
    let waiting = moving();
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
    waiting.finish().expect_code(1).expect_err("::demo::HALTED");

    let waiting = moving();
    daemon.ctl(&["abort", "demo", "goto"]).expect_code(0);
    waiting.finish().expect_code(0).expect_out("done\n");
    assert!(position().as_f64().unwrap() < 10.0);
}

#[test]
fn the_session_of_the_demo_in_c_passes_on_local() {
    the_session_of_the_demo_in_c("local");
}

#[test]
fn the_session_of_the_demo_in_c_passes_on_shared_memory() {
    the_session_of_the_demo_in_c("shm");
}

#[track_caller]
fn texts_and_sequences_go_in_and_come_out(backend: &str) {
    let daemon = start(backend);
    let name = "a name that no small string of the C++ library holds";
    daemon.ctl(&["call", "demo", "get_name"]).expect_out("name = \"axis\"\n");
    let named = json!({ "name": name }).to_string();
    daemon.ctl(&["call", "demo", "set_name", &named]).expect_code(0);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    let reply = daemon.json(&["call", "demo", "follow", r#"{"route":[0.02,-0.01,0.0]}"#]);
    let stops = json!([
        { "position": 0.02, "velocity": 0.0 },
        { "position": -0.01, "velocity": 0.0 },
        { "position": 0.0, "velocity": 0.0 },
    ]);
    let report = format!("{name} stopped 3 times, at 0.02 m, at -0.01 m, at 0 m");
    assert_eq!(reply["result"], json!({ "stops": stops, "report": report }), "{reply}");
    let passed = json!({ "axis": name, "states": stops, "next": null });
    assert_eq!(value(&daemon, "passed"), passed);

    // Exceptions contain them, too.
    let refused = daemon.ctl(&["call", "demo", "follow", r#"{"route":[1.0,99.0]}"#]);
    refused.expect_code(1).expect_err("::demo::BAD_ROUTE");
    refused.expect_err(r#"{"what":"the axis cannot reach 99.000000 m","route":[1.0,99.0]}"#);
}

#[test]
fn texts_and_sequences_go_in_and_come_out_on_local() {
    texts_and_sequences_go_in_and_come_out("local");
}

#[test]
fn texts_and_sequences_go_in_and_come_out_on_zenoh() {
    texts_and_sequences_go_in_and_come_out("zenoh");
}

/// Output of `--check` for the library with a changed description.
fn checked(from: &str, to: &str) -> (i32, String) {
    let home = Home::new();
    let library = component("demo-cpp").library;
    let text = repository().join("components/demo-cpp/demo-cpp.gen");
    let text = fs::read_to_string(text).unwrap();
    assert!(text.contains(from), "{from}");
    fs::write(home.path().join("other.gen"), text.replacen(from, to, 1)).unwrap();
    let finished = home.refused(&["--check", "--gen", "other.gen", path(&library)]);
    finished.expect_code(i32::from(from != to));
    let line = text.lines().position(|line| line.contains("codel demo_reset(")).unwrap() + 1;
    (i32::try_from(line).unwrap(), finished.err)
}

#[test]
fn another_type_is_refused_with_both_declarations() {
    checked("demo", "demo");
    let (line, said) = checked("demo_reset(inout current)", "demo_reset(inout name)");
    for wanted in [
        &format!("codel `demo_reset` (other.gen:{line}): the C++ function takes other parameters"),
        ".gen:    genom::event demo_reset(std::string &name)",
        "library: demo_reset(demo::state&)",
    ] {
        assert!(said.contains(wanted), "expected `{wanted}` in:\n{said}");
    }
    // The C++ function's name is the same; only its debug information shows the difference.
    let (line, said) = checked("double velocity;   /* m/s */", "float velocity;");
    for wanted in [
        &format!("codel `demo_reset` (other.gen:{line}): argument 1 `current`: "),
        "`demo::state.velocity`: `float` is wanted, not `double`",
        ".gen:    genom::event demo_reset(demo::state &current)",
    ] {
        assert!(said.contains(wanted), "expected `{wanted}` in:\n{said}");
    }
}

#[test]
fn the_header_of_the_codels_is_the_one_that_genomctl_writes() {
    let folder = repository().join("components/demo-cpp");
    let mut command = Command::new(program("genomctl"));
    command.env_clear().args(["header", "--lang", "c++", path(&folder.join("demo-cpp.gen"))]);
    let written = Running::start(&mut command).finish();
    written.expect_code(0);
    let kept = fs::read_to_string(folder.join("codels/demo_types.h")).unwrap();
    assert!(written.out == kept, "demo_types.h is old: write it anew with genomctl header");
}
