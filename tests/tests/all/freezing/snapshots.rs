//! Copies of the IDS of components in cells, put back after a crash.

use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;

use genom_tests::{Daemon, Home, component, until};
use serde_json::json;

use crate::cells::signal;

fn in_a_cell(how: &str) -> Daemon {
    let library = component("demo").library;
    let text = format!("[[component]]\nlibrary = {library:?}\ncell = \"arm\"\n{how}\n");
    Home::new().configured(&text).start(&[])
}

fn copy(daemon: &Daemon) -> PathBuf {
    let mut all = daemon.home().socket().into_os_string();
    all.push(".cells/arm/demo.snapshot");
    all.into()
}

/// Waits until there is a copy with this text.
#[track_caller]
fn until_copied(daemon: &Daemon, wanted: &str) {
    let file = copy(daemon);
    until("a copy is made", || {
        std::fs::read_to_string(&file).is_ok_and(|text| text.contains(wanted))
    });
}

/// Kills the process of the cell; before that, when it has stopped, does `meanwhile`.
#[track_caller]
fn crash(daemon: &Daemon, meanwhile: impl FnOnce()) {
    let mut events = daemon.events();
    signal(daemon, "arm", "STOP");
    meanwhile();
    signal(daemon, "arm", "KILL");
    events.wait_for(|event| event["event"] == "cell_runs");
}

#[test]
fn the_ids_of_a_crashed_component_are_put_back_from_their_last_copy() {
    let daemon = in_a_cell("snapshot = 0.02");
    daemon.ctl(&["call", "demo", "goto", "goal=0.03"]).expect_code(0);
    until_copied(&daemon, "\"position\": 0.03");
    let mode = std::fs::metadata(copy(&daemon)).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600, "nobody else reads it");
    crash(&daemon, || {});
    assert_eq!(daemon.port("demo", "position")["value"]["position"], json!(0.03));
    let why = daemon.ctl(&["why", "demo/position"]);
    assert!(why.out.contains("it goes on with the IDS and ports of "), "{}", why.out);
    // Without activities: it stands still, and takes a new goal from where it is.
    assert_eq!(daemon.json(&["activities", "demo"])["activities"], json!([]));
    daemon.ctl(&["call", "demo", "goto", "goal=0.04"]).expect_code(0);
}

#[test]
fn activities_of_a_crashed_component_go_on_if_that_is_asked_for() {
    let daemon = in_a_cell("snapshot = 0.02\nrestore = \"activities\"");
    daemon.ctl(&["start", "demo", "goto", "goal=2"]).expect_code(0);
    until_copied(&daemon, "\"service\": \"goto\"");
    crash(&daemon, || {});
    let activities = daemon.json(&["activities", "demo"])["activities"].clone();
    assert_eq!(activities[0]["service"], json!("goto"), "{activities}");
    assert_eq!(activities[0]["status"], json!("running"));
    let position = || daemon.port("demo", "position")["value"]["position"].as_f64().unwrap_or(0.0);
    let seen = position();
    until("the axis moves", || position() > seen);
}

#[test]
fn a_copy_that_cannot_be_used_is_left_out_and_told() {
    let daemon = in_a_cell("snapshot = 3600");
    until_copied(&daemon, "\"ids\"");
    let other = "{\"component\": \"mission\", \"digest\": \"\"}";
    crash(&daemon, || std::fs::write(copy(&daemon), other).unwrap());
    let told = daemon.process().error_line_where(|line| line.contains("its copy does not fit"));
    assert!(told.unwrap().contains("this is the state of a mission, and not of a demo"));
    daemon.ctl(&["call", "demo", "get_position"]).expect_code(0);
    let refused = Home::new().configured("[[component]]\nlibrary = \"demo\"\nsnapshot = 0.001\n");
    refused.refused(&[]).expect_code(2).expect_err("0.001 is not between 0.02 and 3600 s");
}
