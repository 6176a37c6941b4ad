//! What was frozen goes on as if nothing had happened.

use std::os::unix::fs::PermissionsExt as _;

use genom_tests::{Daemon, Home, Many, component};
use serde_json::{Value, json};

use super::{changed, empty, file, freeze, robot, thaw};

const BOTH: [&str; 2] = ["demo", "far"];

/// Starts a motion of both.
fn set_off(daemon: &Daemon) {
    for name in BOTH {
        daemon.ctl(&["call", name, "set_speed", "velocity=0.8"]).expect_code(0);
        daemon.ctl(&["start", name, "goto", "goal=0.02"]).expect_code(0);
    }
}

/// Ports and activities of both after each of some steps of 10 ms.
fn course(daemon: &Daemon, steps: usize) -> Vec<[Value; 4]> {
    let look = |_| {
        daemon.ctl(&["step", "10ms"]).expect_code(0);
        let [demo, far] = BOTH.map(|name| {
            let port = daemon.port(name, "position")["value"].clone();
            let activities = daemon.json(&["activities", name])["activities"].clone();
            [port, activities]
        });
        let ([a, b], [c, d]) = (demo, far);
        [a, b, c, d]
    };
    (0..steps).map(look).collect()
}

#[test]
fn a_motion_goes_on_in_another_daemon_step_by_step_as_it_would_have() {
    let first = robot();
    set_off(&first);
    course(&first, 6);
    let (text, told) = freeze(&first);
    assert!(told.contains(": 2 components, 2 activities, "), "{told}");
    let mode = std::fs::metadata(file(&first)).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    assert!(!text.contains(first.home().memory().prefix()), "options of middlewares are left out");
    let expected = course(&first, 22);
    assert_ne!(expected[0][0], expected[10][0], "it moves");
    assert_eq!(expected[21][0]["position"], json!(0.02), "it arrives");
    first.stop("TERM").0.expect_code(0);

    let second = empty();
    let told = thaw(&second, &text, &[]);
    assert_eq!(told, "demo goes on with 1 activity\nfar goes on with 1 activity\n");
    assert_eq!(course(&second, 22), expected);
    // The attribute and the deployment are there, too; the calls were not made again.
    let dump = second.ctl(&["dump"]);
    assert!(dump.out.contains("velocity = 0.8") && dump.out.contains("cell = \"arm\""));
    assert_eq!(second.json(&["call", "far", "get_speed"])["result"], json!({"velocity": 0.8}));
}

#[test]
fn an_activity_that_goes_on_ends_and_is_waited_for_and_aborted_as_any_other() {
    let first = robot();
    set_off(&first);
    course(&first, 3);
    let (text, _) = freeze(&first);
    let second = empty();
    thaw(&second, &text, &[]);
    second.ctl(&["abort", "far", "2"]).expect_code(0);
    second.ctl(&["step", "1s"]).expect_code(0);
    second.ctl(&["wait", "demo", "2"]).expect_code(0).expect_out("done\n");
    second.ctl(&["wait", "far", "2"]).expect_code(0);
    let far = second.port("far", "position")["value"].clone();
    assert!(far["position"].as_f64().unwrap() < 0.02, "it braked: {far}");
}

#[test]
fn another_description_takes_values_over_by_names_and_the_rest_is_listed() {
    let first = robot();
    set_off(&first);
    course(&first, 6);
    let (text, _) = freeze(&first);
    let text = changed(&text, |frozen| {
        let demo = &mut frozen["components"]["demo"];
        demo["ids"]["digest"] = json!("of another version");
        let ids = demo["ids"]["value"].as_object_mut().unwrap();
        ids.remove("halted");
        ids.insert("before".to_owned(), json!(1));
        ids["velocity"] = json!(0.25);
        demo["ports"]["gone"] = demo["ports"]["position"].clone();
        demo["tasks"]["old"] = json!([]);
        demo["activities"][0]["service"] = json!("dance");
    });
    let second = empty();
    let told = thaw(&second, &text, &[]);
    assert_eq!(
        told,
        "demo goes on\n  ids: halted is new\n  ids: before is gone\n  \
         ports.gone: the description has no such port\n  \
         tasks.old: the description has no such task\n  \
         activities[0]: dance does not go on: the description has no such activity\n\
         far goes on with 1 activity\n"
    );
    assert_eq!(second.json(&["call", "demo", "get_speed"])["result"], json!({"velocity": 0.25}));
    let listed = second.json(&["list"]);
    assert_eq!(listed["components"][0]["notes"].as_array().unwrap().len(), 5, "{listed}");
}

#[test]
fn connections_of_a_frozen_system_are_made_before_it_goes_on() {
    let (demo, mission) = (component("demo"), component("mission"));
    let text = format!(
        "[[component]]\nlibrary = {:?}\n[[component]]\nlibrary = {:?}\ncell = \"brain\"\n\
         [[connection]]\nin = \"mission/position\"\nout = \"demo/position\"\n\
         [[connection]]\nin = \"demo/parameter\"\nout = \"mission/gain\"\n\
         [[connection]]\nin = \"mission/goto\"\nout = \"demo/goto\"\n",
        demo.library, mission.library,
    );
    let first = Home::new().configured(&text).start(&[]);
    first.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    first.ctl(&["call", "mission", "set_turns", "turns={\"far\":0.02}"]).expect_code(0);
    first.ctl(&["start", "mission", "patrol", "rounds=1000"]).expect_code(0);
    let (text, _) = freeze(&first);
    let before = first.json(&["connections"]);
    first.stop("TERM").0.expect_code(0);
    let second = Daemon::start(&[]);
    thaw(&second, &text, &[]);
    let after = second.json(&["connections"]);
    let by_name = |all: &Value| {
        let mut all = all["connections"].as_array().unwrap().clone();
        all.sort_by_key(|one| one["in"].to_string());
        all.iter().map(|one| (one["in"].clone(), one["out"].clone())).collect::<Vec<_>>()
    };
    assert_eq!(by_name(&before), by_name(&after));
    // The mission goes on, and moves the axis through its cell's connection.
    let moves = || second.port("demo", "position")["traffic"]["samples"].as_u64().unwrap_or(0);
    let seen = moves();
    genom_tests::until("the axis moves", || moves() > seen + 20);
}

#[test]
fn what_runs_is_replaced_and_comes_back_if_the_file_cannot_be_thawed() {
    let daemon = robot();
    set_off(&daemon);
    course(&daemon, 6);
    let (text, _) = freeze(&daemon);
    let then = course(&daemon, 10);
    let refused = daemon.ctl(&["thaw", file(&daemon).to_str().unwrap()]);
    refused.expect_code(1).expect_err("demo, far run already: unload them first");
    let told = thaw(&daemon, &text, &["--replace"]);
    assert_eq!(told, "demo goes on with 1 activity\nfar goes on with 1 activity\n");
    assert_eq!(course(&daemon, 10), then, "the same steps once more");
    // A file that cannot be thawed: what runs stays as it is.
    let wrong = changed(&text, |frozen| {
        frozen["deployment"]["component"][1]["library"] = json!("/nowhere/demo.so");
    });
    std::fs::write(file(&daemon), wrong).unwrap();
    let now = daemon.port("demo", "position")["value"].clone();
    let refused = daemon.ctl(&["thaw", "--replace", file(&daemon).to_str().unwrap()]);
    refused.expect_code(1).expect_err("load far: ").expect_err("everything is as it was before");
    assert_eq!(daemon.port("demo", "position")["value"], now);
    assert_eq!(daemon.json(&["activities", "far"])["activities"][0]["status"], json!("running"));
    daemon.ctl(&["step", "1s"]).expect_code(0);
    daemon.ctl(&["wait", "far", "2"]).expect_code(0).expect_out("done\n");
}

#[test]
fn fifty_components_are_frozen_and_thawed() {
    let made = tempfile::tempdir().unwrap();
    let text = Many { components: 50, chained: true, cells: 0 }.configuration("local", made.path());
    let first = Home::new().configured(&text).start(&[]);
    first.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let (text, told) = freeze(&first);
    assert!(told.contains(": 50 components, "), "{told}");
    first.stop("TERM").0.expect_code(0);
    let second = Daemon::start(&[]);
    let told = thaw(&second, &text, &[]);
    assert_eq!(told.lines().filter(|line| line.contains(" goes on")).count(), 50, "{told}");
    assert_eq!(second.json(&["connections"])["connections"].as_array().unwrap().len(), 100);
}
