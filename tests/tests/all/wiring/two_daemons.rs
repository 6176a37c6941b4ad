//! Two daemons on one machine: the out port of one feeds the in port of the other.

use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path, until};
use serde_json::Value;

/// The 2010 paper's component publishes a double, and the demo reads one.
fn pair(backend: &str) -> (Daemon, Daemon) {
    let memory = Arc::new(Memory::new());
    let (writer, reader) = (component("demo-2010"), component("demo"));
    let writer = Home::with(&memory).start(&[
        "--backend",
        backend,
        "--name",
        "paper",
        path(&writer.description),
    ]);
    let reader = Home::with(&memory).start(&["--backend", backend, path(&reader.library)]);
    (writer, reader)
}

/// The last value that the demo read from its in port.
fn parameter(reader: &Daemon) -> Value {
    reader.port("demo", "parameter")
}

fn feeds(backend: &str) {
    let (writer, reader) = pair(backend);
    let made = reader.ctl(&["connect", "demo/parameter", "paper/position"]);
    made.expect_code(0)
        .expect_out(&format!("demo/parameter reads paper/position ({backend}, latest)\n"));
    writer.ctl(&["call", "paper", "goto", "position=0.5"]).expect_code(0);
    reader.ctl(&["call", "demo", "goto", "goal=0.05"]).expect_code(0);
    let port = parameter(&reader);
    assert_eq!((&port["value"], &port["connected"]), (&0.5.into(), &"paper/position".into()));

    // Without the connection the codels see no new values.
    reader.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(parameter(&reader)["connected"], Value::Null);
    reader.ctl(&["connections"]).expect_code(0).expect_out("");
}

#[test]
fn an_out_port_feeds_an_in_port_of_another_daemon() {
    feeds("shm");
}

#[test]
fn an_out_port_feeds_an_in_port_of_another_daemon_over_zenoh() {
    feeds("zenoh");
}

#[test]
fn a_writer_that_nobody_sees_is_refused_with_what_is_visible() {
    let (_writer, reader) = pair("shm");
    let refused = reader.ctl(&["connect", "demo/parameter", "paper/positon"]);
    refused.expect_code(1).expect_err("nobody publishes paper/positon on shm");
    refused.expect_err("did you mean `paper/position`?").expect_err("--wait");
    let refused = reader.ctl(&["connect", "demo/parameter", "nobody/at_all"]);
    refused.expect_code(1).expect_err("demo/position").expect_err("paper/position");
}

#[test]
fn types_that_differ_are_both_named() {
    let memory = Arc::new(Memory::new());
    let demo = component("demo");
    let start = |name| {
        Home::with(&memory).start(&["--backend", "shm", "--name", name, path(&demo.library)])
    };
    let (_one, two) = (start("one"), start("two"));
    // The demo reads a double and publishes a struct: once across daemons, once within one.
    for writer in ["one/position", "two/position"] {
        let refused = two.ctl(&["connect", "two/parameter", writer]);
        refused.expect_code(1).expect_err("demo::gain").expect_err("demo::state");
    }
    assert_eq!(two.json(&["connections"])["connections"], Value::Array(Vec::new()));
}

#[test]
fn a_writer_that_comes_later_is_waited_for() {
    let memory = Arc::new(Memory::new());
    let (writer, reader) = (component("demo-2011"), component("demo"));
    let reader = Home::with(&memory).start(&["--backend", "shm", path(&reader.library)]);
    reader.ctl(&["connect", "--wait", "demo/parameter", "paper/position"]).expect_code(0);
    // Connected but never written: the codels run with their default.
    reader.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    assert_eq!(parameter(&reader)["value"], Value::Null);
    let writer = Home::with(&memory).start(&[
        "--backend",
        "shm",
        "--name",
        "paper",
        path(&writer.description),
    ]);
    writer.ctl(&["call", "paper", "goto", "goal=0.25"]).expect_code(0);
    reader.ctl(&["call", "demo", "goto", "goal=0.02"]).expect_code(0);
    assert_eq!(parameter(&reader)["value"], 0.25);
}

#[test]
fn the_policy_of_a_connection_is_chosen_when_it_is_made() {
    let (_writer, reader) = pair("shm");
    for policy in ["queue:4", "ring:4", "latest"] {
        let made = reader.ctl(&["connect", "demo/parameter", "paper/position", "--policy", policy]);
        let shown = format!("demo/parameter reads paper/position (shm, {policy})\n");
        made.expect_code(0).expect_out(&shown);
    }
    let refused = reader.ctl(&["connect", "demo/parameter", "paper/position", "--policy", "fifo"]);
    refused.expect_code(1).expect_err("queue:N");
    // An in port has one connection.
    assert_eq!(reader.json(&["connections"])["connections"].as_array().unwrap().len(), 1);
}

#[test]
fn components_of_one_daemon_connect_too() {
    for backend in ["local", "shm"] {
        let (demo, paper) = (component("demo"), component("demo-2010"));
        let daemon = Daemon::start(&["--backend", backend, path(&demo.library)]);
        daemon.ctl(&["load", path(&paper.description), "--name", "paper"]).expect_code(0);
        daemon.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
        daemon.ctl(&["call", "paper", "goto", "position=0.125"]).expect_code(0);
        daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
        assert_eq!(parameter(&daemon)["value"], 0.125, "{backend}");
        // A supervisor that uses GenoM3's own service gets the same (genom3.md 4.8).
        let inputs = r#"{"local":"parameter","remote":"paper/nothing"}"#;
        let refused = daemon.ctl(&["call", "demo", "connect_port", inputs]);
        refused.expect_code(1).expect_err("::genom::no_such_outport");
    }
}

#[test]
fn a_connection_follows_a_writer_that_moves_after_its_reader() {
    let (writer, reader) = pair("shm");
    reader.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    writer.ctl(&["call", "paper", "goto", "position=0.5"]).expect_code(0);
    let backend = || reader.json(&["connections"])["connections"][0]["backend"].clone();
    // Nobody publishes there yet, so the previous samples keep arriving.
    reader.ctl(&["backend", "demo", "zenoh"]).expect_code(0);
    assert_eq!(backend(), "shm");
    writer.ctl(&["backend", "paper", "zenoh"]).expect_code(0);
    until("the reader follows", || backend() == "zenoh");
    until("the value arrives", || {
        reader.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
        reader.ctl(&["call", "demo", "goto", "goal=0"]).expect_code(0);
        parameter(&reader)["value"] == 0.5
    });
}
