//! The process of a cell ends by itself: others go on, and what was in it comes back.

use genom_tests::{Daemon, Home, until};
use serde_json::json;

use super::{cell, load, mission, signal};

#[test]
fn a_codel_that_crashes_takes_down_its_cell_alone() {
    let daemon = Daemon::demo("local");
    let mut events = daemon.events();
    load(&daemon, "crashes", &["--isolated"]);
    let asked = daemon.ctl(&["call", "crashes", "segfault"]);
    asked.expect_code(1).expect_err("::genom::gone");
    let ended = events.wait_for(|e| e["event"] == "cell_ended");
    assert_eq!(ended["why"], json!("signal 11 (SIGSEGV)"));
    assert_eq!(ended["components"], json!(["crashes"]));
    events.wait_for(|e| e["event"] == "cell_runs");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    // It is back, and the activity that brought it down is not started again.
    assert_eq!(daemon.json(&["activities", "crashes"])["activities"], json!([]));
    let now = cell(&daemon, "crashes");
    assert_eq!((&now["starts"], &now["state"]), (&json!(2), &json!("running")));
}

#[test]
fn a_codel_that_raises_the_signal_to_stop_takes_nothing_out_of_its_cell() {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "leaves", &["--isolated"]);
    // It may still be answered: the process stops in order.
    let _ = daemon.ctl(&["call", "leaves", "terminate"]);
    let ended = events.wait_for(|e| {
        let kind = &e["event"];
        assert!(kind != "component_unloaded" && kind != "stopping", "{e}");
        kind == "cell_ended"
    });
    assert_eq!((&ended["why"], &ended["restarts"]), (&json!("exit status 1"), &json!(true)));
    events.wait_for(|e| e["event"] == "cell_runs");
    daemon.ctl(&["call", "leaves", "small"]).expect_code(1).expect_err("::genom::unkex");
}

#[test]
fn what_was_in_a_cell_comes_back_configured_and_wired() {
    let home = Home::new().configured(&mission("attributes = { set_speed = { velocity = 2.0 } }"));
    let daemon = home.start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    let before = daemon.json(&["connections"]);
    let mut events = daemon.events();
    signal(&daemon, "base", "KILL");
    events.wait_for(|e| e["event"] == "cell_runs" && e["cell"] == "base");
    assert_eq!(
        daemon.json(&["call", "demo", "get_speed"])["result"],
        json!({"velocity": 2.0}),
        "attributes"
    );
    until("connections are made again", || daemon.json(&["connections"]) == before);
    // The connections of the other cell, which did not end, heal by themselves: the mission reads
    // where the axis is, and calls its service.
    until("the mission goes on", || {
        daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).code == Some(0)
    });
    assert_eq!(cell(&daemon, "brain")["starts"], json!(1));
}

#[test]
fn the_restart_policy_of_a_component_says_whether_it_comes_back() {
    let daemon = Daemon::start(&[]);
    let mut events = daemon.events();
    load(&daemon, "crashes", &["--name", "never", "--isolated", "--restart", "never"]);
    load(&daemon, "crashes", &["--name", "failing", "--isolated"]);
    load(&daemon, "crashes", &["--name", "always", "--isolated", "--restart", "always"]);
    let names: Vec<_> = daemon.json(&["cells"])["cells"].as_array().unwrap().clone();
    assert_eq!(names.len(), 3, "{names:?}");
    for (name, restarts) in [("never", false), ("failing", true), ("always", true)] {
        signal(&daemon, name, "KILL");
        let ended = events.wait_for(|e| e["event"] == "cell_ended" && e["cell"] == name);
        assert_eq!(ended["restarts"], json!(restarts), "{name}");
    }
    until("two are back", || {
        let list = daemon.json(&["list"]);
        let running = list["components"].as_array().unwrap().iter();
        running.filter(|one| one["state"] == "running").count() == 2
    });
    assert_eq!(cell(&daemon, "never")["state"], "failed");
    // Somebody who asks for it gets it back, from a cell that has failed and from one that runs.
    for starts in [2, 3] {
        daemon.ctl(&["cells", "--restart", "never"]).expect_code(0);
        assert_eq!(cell(&daemon, "never")["starts"], starts);
        assert_eq!(cell(&daemon, "never")["components"], json!(["never"]));
        daemon.ctl(&["info", "never"]).expect_code(0);
    }
}

#[test]
fn a_cell_that_ends_too_often_has_failed_until_somebody_starts_it() {
    let few = "[cells]\nrestart_most = 2\nrestart_delay = 0.0\n";
    let daemon = Home::new().configured(few).start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let mut events = daemon.events();
    for restarts in [true, true, false] {
        signal(&daemon, "demo", "KILL");
        let ended = events.wait_for(|e| e["event"] == "cell_ended");
        assert_eq!(ended["restarts"], json!(restarts));
        if restarts {
            events.wait_for(|e| e["event"] == "cell_runs");
        }
    }
    assert_eq!(cell(&daemon, "demo")["state"], "failed");
    assert_eq!(daemon.json(&["list"])["components"][0]["state"], "down");
    let refused = daemon.ctl(&["call", "demo", "get_speed"]);
    refused.expect_code(1).expect_err("genomctl cells --restart demo");
    daemon.ctl(&["cells", "--restart", "demo"]).expect_code(0);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
}

#[test]
fn a_cell_that_answers_nothing_is_killed_and_comes_back() {
    let daemon = Home::new().configured("[cells]\nalive_timeout = 0.3\n").start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let mut events = daemon.events();
    signal(&daemon, "demo", "STOP");
    let ended = events.wait_for(|e| e["event"] == "cell_ended");
    assert_eq!(ended["why"], json!("killed: it answered nothing for 0.3 s"));
    events.wait_for(|e| e["event"] == "cell_runs");
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0);
}
