//! A deployment that cannot be completed leaves a working daemon unchanged.

use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path};
use serde_json::{Value, json};

/// The state before: a writer on two middlewares, a reader of it, an axis that moves for hours, one
/// that is never changed, and one whose port has a name that another daemon also uses.
fn before() -> String {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let load = |library: &std::path::Path, name: &str, rest: &str| {
        format!(
            "[[component]]\nlibrary = {library:?}\nname = {name:?}\nbackend = \"shm\"\n{rest}\n"
        )
    };
    [
        load(&paper.description, "paper", "ports = { position = [\"shm\", \"local\"] }"),
        load(&demo.library, "reader", "attributes = { set_speed = { velocity = 0.75 } }"),
        load(&demo.library, "mast", "attributes = { set_speed = { velocity = 0.0001 } }"),
        load(&demo.library, "plain", ""),
        load(&paper.description, "clash", "").replace("\"shm\"", "\"local\""),
        "[[connection]]\nin = \"reader/parameter\"\nout = \"paper/position\"\n\
         policy = \"ring:4\"\n[[call]]\ncomponent = \"paper\"\nservice = \"goto\"\n\
         inputs = { position = 0.25 }\n[[activity]]\ncomponent = \"mast\"\nservice = \"goto\"\n\
         inputs = { goal = 1.0 }\n"
            .to_owned(),
    ]
    .concat()
}

/// The same with a change of each kind: middlewares of components and ports, attributes (one that
/// was set before, one that was not), connections, an additional component, an additional activity.
fn changed() -> String {
    let demo = component("demo");
    let text = before()
        .replacen("\"shm\"\nports = { position = [\"shm\", \"local\"] }", "\"local\"", 1)
        .replacen("velocity = 0.75", "velocity = 0.5", 1)
        .replacen(
            "name = \"plain\"\nbackend = \"shm\"",
            "name = \"plain\"\nbackend = \"shm\"\nports = { position = \"local\" }\n\
             attributes = { set_speed = { velocity = 0.125 } }",
            1,
        )
        .replacen("policy = \"ring:4\"", "policy = \"queue:8\"", 1);
    format!(
        "{text}[[component]]\nlibrary = {:?}\nname = \"extra\"\n\
         [[connection]]\nin = \"plain/parameter\"\nout = \"paper/position\"\n\
         [[activity]]\ncomponent = \"extra\"\nservice = \"goto\"\n\
         [[activity]]\ncomponent = \"plain\"\nservice = \"goto\"\ninputs = {{ goal = 0.875 }}\n",
        demo.library
    )
}

/// The state as a supervisor sees it.
fn state(daemon: &Daemon) -> Value {
    let speed = |name: &&str| daemon.json(&["call", name, "get_speed"])["result"].clone();
    let running = |name: &&str| {
        let all = daemon.json(&["activities", name])["activities"].clone();
        let all = all.as_array().unwrap().iter();
        all.filter(|one| one["status"] == "running").cloned().collect::<Vec<_>>()
    };
    let demos = ["reader", "mast", "plain"];
    json!({
        "dump": daemon.json(&["dump"])["text"],
        "connections": daemon.json(&["connections"]),
        "list": daemon.json(&["list"]),
        "speeds": demos.iter().map(speed).collect::<Vec<_>>(),
        "activities": demos.iter().map(running).collect::<Vec<_>>(),
        "value": daemon.port("paper", "position")["value"],
    })
}

fn apply(daemon: &Daemon, text: &str) -> genom_tests::Finished {
    let file = daemon.home().path().join("robot.toml");
    std::fs::write(&file, text).unwrap();
    daemon.ctl(&["apply", "--timeout", "0.1", path(&file)])
}

/// Another daemon that publishes `clash/position` with another type, and the daemon under test.
fn at_work() -> (Daemon, Daemon) {
    let memory = Arc::new(Memory::new());
    let demo = component("demo");
    let other = Home::with(&memory);
    let other = other.start(&["--backend", "shm", "--name", "clash", path(&demo.library)]);
    let daemon = Home::with(&memory).start(&["--backend", "shm"]);
    apply(&daemon, &before()).expect_code(0);
    (daemon, other)
}

#[test]
fn whatever_step_fails_everything_is_as_it_was() {
    let (daemon, _other) = at_work();
    let was = state(&daemon);
    let component = "[[component]]\nname = \"last\"\nlibrary = ";
    let connection = "[[connection]]\nin = \"mast/parameter\"\nout = ";
    let request = |section: &str, service: &str, inputs: &str| {
        format!(
            "[[{section}]]\ncomponent = \"reader\"\nservice = {service:?}\ninputs = {{ {inputs} }}\n"
        )
    };
    let faults = [
        (format!("{component}\"/nowhere/last.so\"\n"), "component.library"),
        (format!("{connection}\"mast/position\"\n"), "connection.out"),
        (format!("{connection}\"mast/nothing\"\n"), "connection.out"),
        (format!("{connection}\"nobody/position\"\n"), "nothing after"),
        (request("call", "set_speed", "velocity = 99.0"), "reader/set_speed ended with"),
        (request("call", "set_sped", "velocity = 0.5"), "did you mean `set_speed`?"),
        (request("activity", "goto", "goal = 99.0"), "reader/goto ended with"),
        (request("activity", "goto", "gaol = 0.5"), "no input `gaol`"),
    ];
    for (fault, told) in faults {
        let refused = apply(&daemon, &(changed() + &fault));
        refused.expect_code(1).expect_err(told).expect_err("everything is as it was before");
        assert_eq!(state(&daemon), was, "{fault}");
    }
    // A middleware refuses a port of a running component, because its name is taken there.
    let clash =
        changed().replacen("\"clash\"\nbackend = \"local\"", "\"clash\"\nbackend = \"shm\"", 1);
    let refused = apply(&daemon, &clash);
    refused.expect_code(1).expect_err("component.backend: move clash to shm: ");
    assert_eq!(state(&daemon), was);
    // An attribute of a running component is refused.
    let fast = changed().replacen("velocity = 0.125", "velocity = 99.0", 1);
    let refused = apply(&daemon, &fast);
    refused.expect_code(1).expect_err("component.attributes.set_speed: set plain/set_speed");
    assert_eq!(state(&daemon), was);

    // Without the mistake, the file takes effect.
    apply(&daemon, &changed()).expect_code(0);
    assert_ne!(state(&daemon), was);
    apply(&daemon, &changed()).expect_out("nothing to do: everything is as the file says\n");
}

#[test]
fn what_cannot_be_taken_back_is_named() {
    let (daemon, _other) = at_work();
    let request = |section: &str, component: &str, service: &str, inputs: &str| {
        format!(
            "[[{section}]]\ncomponent = {component:?}\nservice = {service:?}\n\
             inputs = {{ {inputs} }}\n"
        )
    };
    let text = before()
        + &request("call", "plain", "reset", "")
        + &request("activity", "mast", "goto", "goal = 0.5")
        + &request("activity", "reader", "goto", "goal = 99.0");
    let refused = apply(&daemon, &text);
    refused.expect_code(1).expect_err("all is as it was, but for: mast/goto was interrupted");
    refused.expect_err("call plain/reset {}");
    // It was not called as part of the deployment, so the dump does not contain it.
    let dumped = daemon.ctl(&["dump"]).out;
    assert!(!dumped.contains("reset"), "{dumped}");
}
