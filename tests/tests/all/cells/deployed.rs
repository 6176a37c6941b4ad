//! Deployments with cells: applied, dumped, pruned.

use genom_tests::{Daemon, Home, component, path, request};
use serde_json::{Value, json};

use super::{files, mission};

#[test]
fn a_dump_of_cells_brings_about_the_same_on_another_daemon() {
    let daemon = Home::new().configured(&mission("restart = \"always\"")).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let dump = daemon.ctl(&["dump"]).out;
    assert!(dump.contains("cell = \"base\"") && dump.contains("restart = \"always\""), "{dump}");
    let connections = daemon.json(&["connections"]);
    drop(daemon);
    let daemon = Daemon::start(&[]);
    let file = daemon.home().path().join("dump.toml");
    std::fs::write(&file, dump).unwrap();
    daemon.ctl(&["apply", genom_tests::path(&file)]).expect_code(0);
    assert_eq!(daemon.json(&["connections"]), connections);
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    // Applied again, nothing is to be done.
    let again = daemon.json(&["apply", genom_tests::path(&file)]);
    assert_eq!(again["steps"], json!([]));
}

#[test]
fn a_component_that_its_cell_refuses_leaves_none_of_the_others_that_were_loaded_before() {
    let daemon = Daemon::start(&[]);
    let demo = genom_tests::component("demo").library;
    let load = |name: &str, cell: &str, library: &std::path::Path| {
        format!("[[component]]\nlibrary = {library:?}\nname = {name:?}\ncell = {cell:?}\n")
    };
    daemon.ctl(&["load", genom_tests::path(&demo), "--cell", "arm"]).expect_code(0);
    let file = daemon.home().path().join("robot.toml");
    let nowhere = std::path::Path::new("/nowhere/last.so");
    let text = [load("a", "arm", &demo), load("b", "base", &demo), load("c", "far", nowhere)];
    std::fs::write(&file, text.concat()).unwrap();
    let refused = daemon.ctl(&["apply", genom_tests::path(&file)]);
    refused.expect_code(1).expect_err("/nowhere/last.so");
    let cells = daemon.json(&["cells"])["cells"].clone();
    let held: Vec<_> = cells.as_array().unwrap().iter().map(|cell| &cell["components"]).collect();
    assert_eq!(held, [&json!(["demo"])], "{cells}");
}

#[test]
fn what_a_deployment_does_not_say_goes_from_cells_too_when_it_prunes() {
    let daemon = Home::new().configured(&mission("")).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let file = daemon.home().path().join("none.toml");
    std::fs::write(&file, "").unwrap();
    let beside = daemon.json(&["apply", genom_tests::path(&file)]);
    assert_eq!(beside["beside"], json!(["component demo", "component mission"]));
    daemon.ctl(&["apply", "--prune", genom_tests::path(&file)]).expect_code(0);
    assert_eq!(daemon.json(&["cells"])["cells"], json!([]));
    assert!(!files(&daemon).exists());
}

#[test]
fn a_component_of_the_daemon_itself_and_one_in_a_cell_are_wired_on_shared_memory() {
    let (demo, mission) = (genom_tests::component("demo"), genom_tests::component("mission"));
    let daemon = Daemon::start(&[genom_tests::path(&demo.library)]);
    daemon.ctl(&["load", "--isolated", genom_tests::path(&mission.library)]).expect_code(0);
    for (inport, outport) in [
        ("mission/position", "demo/position"),
        ("demo/parameter", "mission/gain"),
        ("mission/goto", "demo/goto"),
    ] {
        daemon.ctl(&["connect", inport, outport]).expect_code(0);
    }
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    let connections = daemon.json(&["connections"]);
    let all = connections["connections"].as_array().unwrap();
    assert!(all.iter().all(|one| one["backend"] == "shm"), "{connections}");
}

/// A deployment of the daemon itself (`here`) and of cells (`a` in `arm`, `b` in `base`), with these
/// velocities, and `more`.
fn in_three_processes(velocities: [&str; 3], more: &str) -> String {
    let library = component("demo").library;
    let of = |(name, cell, velocity): (&str, &str, &str)| {
        format!(
            "[[component]]\nlibrary = {library:?}\nname = {name:?}\n{cell}\
             attributes = {{ set_speed = {{ velocity = {velocity} }} }}\n"
        )
    };
    let [here, a, b] = velocities;
    let components =
        [("here", "", here), ("a", "cell = \"arm\"\n", a), ("b", "cell = \"base\"\n", b)];
    components.map(of).concat() + more
}

/// What a supervisor sees of it.
fn state(daemon: &Daemon) -> Value {
    let speed = |name: &str| daemon.json(&["call", name, "get_speed"])["result"].clone();
    let held = |cell: &Value| json!([cell["name"], cell["components"], cell["pid"]]);
    let cells = daemon.json(&["cells"])["cells"].clone();
    json!({
        "dump": daemon.json(&["dump"])["text"],
        "connections": daemon.json(&["connections"]),
        "cells": cells.as_array().unwrap().iter().map(held).collect::<Vec<_>>(),
        "speeds": (["here", "a", "b"].map(speed)),
    })
}

fn apply(daemon: &Daemon, more: &[&str], text: &str) -> genom_tests::Finished {
    let file = daemon.home().path().join("robot.toml");
    std::fs::write(&file, text).unwrap();
    daemon.ctl(&[&["apply", path(&file)], more].concat())
}

/// A change in each of the three processes, a component in a new cell, and connections of readers in
/// two processes.
fn changed(more: &str) -> String {
    let library = component("mission").library;
    let new = format!("[[component]]\nlibrary = {library:?}\ncell = \"brain\"\n");
    let connections = "[[connection]]\nin = \"mission/position\"\nout = \"a/position\"\n\
        [[connection]]\nin = \"here/parameter\"\nout = \"mission/gain\"\n";
    in_three_processes(["0.5", "0.25", "0.125"], &(new + connections + more))
}

#[test]
fn a_deployment_that_one_process_refuses_is_undone_in_all_of_them() {
    let daemon = Daemon::start(&[]);
    apply(&daemon, &[], &in_three_processes(["0.75", "0.875", "0.625"], "")).expect_code(0);
    let was = state(&daemon);
    let call = |component: &str, velocity: &str| {
        format!(
            "[[call]]\ncomponent = {component:?}\nservice = \"set_speed\"\n\
             inputs = {{ velocity = {velocity} }}\n"
        )
    };
    // In the daemon itself, in its first cell, and in its last: others have done their part before.
    for at_fault in ["here", "a", "mission"] {
        let fault = match at_fault {
            "mission" => "[[call]]\ncomponent = \"mission\"\nservice = \"patrol\"\n\
                          inputs = { rounds = -1 }\n"
                .to_owned(),
            name => call(name, "99.0"),
        };
        let refused = apply(&daemon, &[], &changed(&fault));
        refused.expect_code(1).expect_err(at_fault).expect_err("everything is as it was before");
        assert_eq!(state(&daemon), was, "{at_fault}");
    }
    // With `--prune`, a component that is left out is put back.
    let fewer = changed(&call("b", "99.0"));
    let without =
        fewer.replacen("name = \"a\"", "name = \"z\"", 1).replace("a/position", "z/position");
    let refused = apply(&daemon, &["--prune"], &without);
    refused.expect_code(1).expect_err("b/set_speed");
    let names = |state: &Value| {
        state["cells"].as_array().unwrap().iter().map(|cell| cell[1].clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(&state(&daemon)), names(&was));
    assert_eq!(state(&daemon)["speeds"], was["speeds"]);

    // Without a mistake, the file takes effect.
    apply(&daemon, &[], &changed("")).expect_code(0);
    assert_ne!(state(&daemon), was);
}

#[test]
fn the_last_deployment_can_be_undone_in_all_processes_once() {
    let daemon = Daemon::start(&[]);
    let take_back = || request(&daemon.home().socket(), "POST", "/deployment/take_back", "");
    assert_eq!(take_back().status, 409);
    apply(&daemon, &[], &in_three_processes(["0.75", "0.875", "0.625"], "")).expect_code(0);
    let was = state(&daemon);
    apply(&daemon, &[], &changed("")).expect_code(0);
    // A dry run does nothing that could be undone, and forgets nothing.
    apply(&daemon, &["--dry-run"], "").expect_code(0);
    let back = take_back();
    assert_eq!((back.status, back.body), (200, json!({ "left": [] })));
    assert_eq!(state(&daemon), was);
    assert_eq!(take_back().status, 409);
}
