//! The daemon ends without having stopped its cells: they go on, and the next one takes them over.

use genom_tests::{Home, until};
use serde_json::json;

use super::{cell, files, load, mission};

#[test]
fn a_new_daemon_takes_over_the_cells_of_a_dead_one_as_they_are() {
    let home = Home::new().configured(&mission(""));
    let daemon = home.start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let before = (cell(&daemon, "base"), daemon.json(&["connections"]));
    let started = daemon.json(&["start", "mission", "patrol", "rounds=1000"]);
    let home = daemon.abandon();
    let daemon = home.start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let after = (cell(&daemon, "base"), daemon.json(&["connections"]));
    assert_eq!((&after.0["pid"], after.1), (&before.0["pid"], before.1));
    let running = daemon.json(&["activities", "mission"]);
    assert_eq!(running["activities"][0]["activity"], started["activity"]);
    assert_eq!(running["activities"][0]["status"], "running");
    // It is restarted as those that this daemon started itself.
    let mut events = daemon.events();
    super::signal(&daemon, "base", "KILL");
    events.wait_for(|e| e["event"] == "cell_runs" && e["cell"] == "base");
}

#[test]
fn a_cell_that_ended_between_two_daemons_is_started_with_what_it_held() {
    let daemon = Home::new().start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    let pid = cell(&daemon, "demo")["pid"].to_string();
    let home = daemon.abandon();
    genom_tests::signal(&pid, "KILL");
    until("it is gone", || !std::path::Path::new(&format!("/proc/{pid}/exe")).exists());
    let daemon = home.start(&[]);
    assert_ne!(cell(&daemon, "demo")["pid"].to_string(), pid);
    assert_eq!(daemon.json(&["call", "demo", "get_speed"])["result"], json!({"velocity": 2.0}));
}

#[test]
fn cells_that_are_not_to_go_on_alone_stop_with_their_daemon() {
    let daemon = Home::new().configured("[cells]\nwithout_daemon = \"stop\"\n").start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let (pid, files) = (cell(&daemon, "demo")["pid"].to_string(), files(&daemon));
    let home = daemon.abandon();
    until("it ends", || !std::path::Path::new(&format!("/proc/{pid}/exe")).exists());
    assert!(home.memory().files().is_empty(), "its component was unloaded");
    // What it held is still written down.
    assert!(files.join("demo/journal.toml").exists());
}
