//! A cell from its start to its end: what runs in it is used as any other component.

use std::fs;

use genom_tests::{Daemon, component, path};
use serde_json::json;

use super::{cell, files, load};

#[test]
fn a_component_in_a_cell_is_used_as_any_other() {
    let daemon = Daemon::demo("local");
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    for name in ["demo", "far"] {
        daemon.ctl(&["call", name, "set_speed", "velocity=2"]).expect_code(0);
        daemon.ctl(&["call", name, "goto", "goal=0.05"]).expect_code(0).expect_out("done\n");
        let speed = daemon.json(&["call", name, "get_speed"]);
        assert_eq!(speed["result"], json!({"velocity": 2.0}));
        let position = &daemon.port(name, "position")["value"]["position"];
        assert_eq!(position, &json!(0.05));
        daemon.ctl(&["why", &format!("{name}/position")]).expect_code(0);
        assert!(!daemon.json(&["stats", name])["tasks"].as_array().unwrap().is_empty());
        daemon.ctl(&["echo", "-n", "1", &format!("{name}/position")]).expect_code(0);
    }
    let list = daemon.json(&["list"]);
    let cells: Vec<_> =
        list["components"].as_array().unwrap().iter().map(|one| one["cell"].clone()).collect();
    assert_eq!(cells, [json!(null), json!("arm")]);
    assert_ne!(cell(&daemon, "arm")["pid"].as_u64(), Some(daemon.process().id().into()));
    assert!(daemon.ctl(&["list"]).out.contains("CELL"));
}

#[test]
fn what_a_cell_tells_is_heard_at_its_daemon() {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "demo", &["--isolated"]);
    events.wait_for(|e| e["event"] == "cell_runs" && e["cell"] == "demo");
    events.wait_for(|e| e["event"] == "component_loaded" && e["component"] == "demo");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    events.wait_for(|e| e["event"] == "activity_ended" && e["component"] == "demo");
    daemon.ctl(&["unload", "demo"]).expect_code(0);
    events.wait_for(|e| e["event"] == "component_unloaded" && e["component"] == "demo");
}

/// While a cell ends, what it tells is heard as before.
#[test]
fn components_of_a_cell_that_is_ended_are_told_to_be_unloaded() {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "demo", &["--name", "a", "--cell", "arm"]);
    load(&daemon, "demo", &["--name", "b", "--cell", "arm"]);
    daemon.ctl(&["cells", "--end", "arm"]).expect_code(0);
    // They stop side by side: which is told first is open.
    let mut next = || events.wait_for(|e| e["event"] == "component_unloaded")["component"].clone();
    let mut both = [next(), next()].map(|name| name.as_str().unwrap().to_owned());
    both.sort_unstable();
    assert_eq!(both, ["a", "b"]);
}

#[test]
fn a_cell_ends_with_its_last_component_and_leaves_nothing() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    load(&daemon, "demo", &["--name", "a", "--cell", "arm"]);
    load(&daemon, "demo", &["--name", "b", "--cell", "arm"]);
    assert_eq!(cell(&daemon, "arm")["components"], json!(["a", "b"]));
    daemon.ctl(&["unload", "a"]).expect_code(0).expect_out("a unloaded\n");
    assert_eq!(cell(&daemon, "arm")["components"], json!(["b"]));
    daemon.ctl(&["call", "b", "kill"]).expect_code(0);
    genom_tests::until("the cell ends", || daemon.json(&["cells"])["cells"] == json!([]));
    assert!(!files(&daemon).exists());
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert!(home.memory().files().is_empty());
}

#[test]
fn components_of_the_command_line_run_in_a_cell_of_their_own_or_share_one() {
    let (demo, mission) = (component("demo"), component("mission"));
    let both = [path(&demo.library), path(&mission.library)];
    let daemon = Daemon::start(&[&["--isolated"], &both[..]].concat());
    let names = |daemon: &Daemon| {
        let all = daemon.json(&["cells"]);
        let all = all["cells"].as_array().unwrap().iter();
        all.map(|one| one["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(names(&daemon).len(), 2);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
    let daemon = Daemon::start(&["--cell", "one", both[0]]);
    assert_eq!(names(&daemon), ["one"]);
}

#[test]
fn the_end_of_the_daemon_is_that_of_its_cells() {
    let daemon = Daemon::start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let files = files(&daemon);
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
    // It has run for long, and needs several periods to stop.
    let echo = daemon.spawn(&["echo", "demo/position", "--rate", "200"]);
    echo.line_where(|line| line.contains("\"velocity\":0.5"));
    drop(echo);
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    // Interrupted as by any stop: its `stop` codel ran.
    waiting.finish().expect_code(0).expect_out("done\n");
    assert!(!files.exists());
    assert!(home.memory().files().is_empty());
}

/// How an activity ends that began before a daemon was told to stop is learnt by who asks after that.
#[test]
fn a_cell_that_stops_tells_of_its_activities_until_they_have_ended() {
    let daemon = Daemon::start(&["--set", "stop_timeout=60"]);
    load(&daemon, "blocks", &["--isolated"]);
    let file = daemon.home().path().join("go on");
    let input = format!("file={}", path(&file));
    daemon.ctl(&["start", "blocks", "hang_until", &input]).expect_code(0);
    daemon.process().signal("TERM");
    genom_tests::until("it stops", || cell(&daemon, "blocks")["state"] == "stopping");
    // Its cell hears of it a moment later.
    genom_tests::until("the cell stops", || {
        daemon.ctl(&["call", "blocks", "get_count"]).code == Some(1)
    });
    daemon
        .ctl(&["wait", "blocks", "hang_until", "--timeout", "0.01"])
        .expect_code(1)
        .expect_err("still runs after 0.01 s");
    fs::write(&file, "").unwrap();
    daemon.finish().0.expect_code(0);
}
