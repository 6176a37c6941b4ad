//! Values that are published to in ports with `genomctl pub` and its route.

use genom_tests::{Daemon, component, path, request};
use serde_json::json;

/// The gain stops the axis at once, whatever its goal, because the codels read it.
#[track_caller]
fn a_published_gain_reaches_the_codels(backend: &str) {
    let daemon = Daemon::demo(backend);
    let mut events = daemon.events();
    daemon.ctl(&["pub", "demo/parameter", "0"]).expect_code(0).expect_out("demo/parameter = 0.0\n");
    events.wait_for(|e| {
        e["event"] == "connected" && e["in"] == "demo/parameter" && e["out"] == "demo/parameter"
    });
    assert_eq!(daemon.port("demo", "parameter")["connected"], "demo/parameter");
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=0.1"]);
    let echo = daemon.spawn(&["echo", "demo/parameter"]);
    assert_eq!(echo.line(), "0.0");
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.0);
    // Later values arrive, too: the axis moves and reaches its goal.
    daemon.ctl(&["pub", "demo/parameter", "1.0"]).expect_code(0);
    waiting.finish().expect_code(0);
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.1);
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(daemon.port("demo", "parameter")["connected"], json!(null));
    // The address is free again.
    daemon.ctl(&["pub", "demo/parameter", "0.5"]).expect_code(0);
}

#[test]
fn a_published_gain_reaches_the_codels_on_local() {
    a_published_gain_reaches_the_codels("local");
}

#[test]
fn a_published_gain_reaches_the_codels_on_shared_memory() {
    a_published_gain_reaches_the_codels("shm");
}

#[test]
fn what_cannot_be_published_is_refused_with_the_way_out() {
    let daemon = Daemon::demo("local");
    daemon.ctl(&["pub", "demo/position", "1"]).expect_code(1).expect_err("is an out port");
    daemon.ctl(&["pub", "demo/parametre", "1"]).expect_code(1).expect_err("mean `parameter`?");
    daemon.ctl(&["pub", "demo/parameter", "fast"]).expect_code(1).expect_err("number");
    // The port was not connected by it.
    assert_eq!(daemon.port("demo", "parameter")["connected"], json!(null));
}

#[test]
fn a_port_that_a_component_feeds_is_not_taken_from_it() {
    let (demo, rust) = (component("demo"), component("demo-rs"));
    let daemon = Daemon::start(&["--backend", "local", path(&demo.library)]);
    daemon.ctl(&["load", "--name", "other", path(&rust.library)]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "demo/parameter", "elsewhere/gain"]).expect_code(0);
    let refused = daemon.ctl(&["pub", "demo/parameter", "1"]);
    refused.expect_code(1).expect_err("demo/parameter reads elsewhere/gain");
    refused.expect_err("help: `genomctl disconnect demo/parameter` first");
    // And the other way round: a connection replaces the published value.
    daemon.ctl(&["pub", "other/parameter", "0.5"]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "other/parameter", "elsewhere/gain"]).expect_code(0);
    assert_eq!(daemon.port("other", "parameter")["connected"], "elsewhere/gain");
}

#[test]
fn the_type_of_a_port_is_told_as_it_lies_in_memory() {
    let daemon = Daemon::demo("shm");
    let socket = daemon.home().socket();
    let reply = request(&socket, "GET", "/components/demo/ports/position/type", "");
    assert_eq!(reply.status, 200);
    let told = &reply.body;
    assert_eq!(told["type"], "::demo::state");
    assert_eq!((&told["types"][0]["size"], &told["types"][0]["align"]), (&json!(16), &json!(8)));
    let members = &told["types"][0]["members"];
    assert_eq!(members[1], json!({"name": "velocity", "offset": 8, "type": 1}));
    assert_eq!(told["types"][1]["kind"], "double");
    // How a foreign program reaches the ports of this daemon.
    let reply = request(&socket, "GET", "/middlewares", "");
    let all = reply.body["middlewares"].as_array().unwrap();
    let shm = all.iter().find(|one| one["name"] == "shm").unwrap();
    assert_eq!(shm["meet"]["prefix"], daemon.home().memory().prefix());
}
