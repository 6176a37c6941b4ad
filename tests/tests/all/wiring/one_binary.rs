//! One binary component on every middleware: only one line of the configuration changes.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash as _, Hasher as _};

use genom_tests::{Daemon, Home, component, path};
use serde_json::{Value, json};

/// A supervisor's session and its replies; they are the same on every middleware.
fn session(daemon: &Daemon) -> Vec<Value> {
    let ctl = |arguments: &[&str]| {
        let finished = daemon.ctl(arguments);
        json!({"code": finished.code, "out": finished.out, "err": finished.err})
    };
    let moved = [
        ctl(&["call", "demo", "set_speed", "velocity=2"]),
        ctl(&["call", "demo", "get_speed"]),
        ctl(&["call", "demo", "set_speed", "velocity=9"]),
        ctl(&["start", "--wait", "demo", "goto", "goal=0.5"]),
        ctl(&["call", "demo", "get_position"]),
    ];
    let position = daemon.port("demo", "position")["value"].clone();
    // A value from outside passes through the middleware: a gain of 0 keeps the axis in place.
    daemon.ctl(&["pub", "demo/parameter", "0"]).expect_code(0);
    let mut events = daemon.events();
    let held = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=0"]);
    events.wait_for(|e| e["state"] == "main");
    daemon.ctl(&["pub", "demo/parameter", "1"]).expect_code(0);
    held.finish().expect_code(0);
    let back = daemon.port("demo", "position")["value"].clone();
    moved.into_iter().chain([position, back, ctl(&["call", "demo", "goto", "goal=99"])]).collect()
}

#[test]
fn the_same_binary_does_the_same_on_every_middleware() {
    let demo = component("demo");
    let mut hash = DefaultHasher::new();
    std::fs::read(&demo.library).unwrap().hash(&mut hash);
    let checksum = hash.finish();
    let mut sessions = Vec::new();
    for backend in ["local", "shm", "zenoh", "ros2"] {
        let home = Home::new().configured(&format!("backend = {backend:?}"));
        let daemon = home.start(&[path(&demo.library)]);
        println!("{backend}: {} {checksum:016x}", demo.library.display());
        sessions.push((backend, session(&daemon)));
    }
    let (_, first) = &sessions[0];
    assert_eq!(first[1]["out"], "velocity = 2.0\n");
    assert_eq!(first[2]["code"], 1);
    assert_eq!(first[5], json!({"position": 0.5, "velocity": 0.0}));
    assert_eq!(first[6], json!({"position": 0.0, "velocity": 0.0}));
    for (backend, told) in &sessions {
        assert_eq!(told, first, "{backend}");
    }
}
