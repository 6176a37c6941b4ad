//! Several daemons that see each other over zenoh, controlled through one of them.

use std::process::Command;
use std::sync::Arc;

use genom_tests::fleet::{IN_A_LIBRARY, at_the_robot, fleet, fleet_on, in_a_library};
use genom_tests::{Daemon, Home, Memory, Running, component, path, repository};
use serde_json::json;

#[test]
fn a_daemon_is_supervised_through_another_one() {
    supervised(&fleet(), "zenoh");
}

#[test]
fn a_daemon_is_supervised_through_one_with_zenoh_in_a_library() {
    supervised(&fleet_on("zenoh", IN_A_LIBRARY), IN_A_LIBRARY);
}

#[test]
fn a_daemon_with_zenoh_in_a_library_is_supervised_through_another_one() {
    supervised(&fleet_on(IN_A_LIBRARY, "zenoh"), "zenoh");
}

/// The robot does what is asked of it at the desk, which sees it on this middleware.
fn supervised((robot, desk): &(Daemon, Daemon), seen_on: &str) {
    let far = |arguments: &[&str]| at_the_robot(robot, desk, "driver", arguments);
    let listed = far(&["list"]);
    assert!(listed.expect_code(0).out.contains("demo"), "{}", listed.out);
    desk.ctl(&["daemons"])
        .expect_code(0)
        .expect_out(&format!("DAEMON  BACKEND\ndesk*   {seen_on}\nrobot   {seen_on}\n"));
    far(&["call", "demo", "set_speed", "velocity=0.25"]).expect_code(0);
    robot.ctl(&["call", "demo", "get_speed"]).expect_code(0).expect_out("velocity = 0.25\n");
    // Waits for an activity as if it ran here.
    far(&["start", "--wait", "demo", "goto", "goal=0.01"]).expect_code(0);
    // A refusal arrives unchanged.
    let refused = far(&["call", "demo", "goto", "gaol=1"]);
    refused.expect_code(1).expect_err("did you mean `goal`?");
}

#[test]
fn a_daemon_that_shows_on_one_of_two_middlewares_is_asked_there() {
    let (robot, _other) = fleet();
    // This one is alone on its zenoh, and meets the robot with that in the library.
    let section = in_a_library(robot.home().memory());
    let desk = Home::new().configured(&section).start(&["--backend", "zenoh"]);
    let demo = component("demo").library;
    desk.ctl(&["load", "--backend", IN_A_LIBRARY, "--name", "own", path(&demo)]).expect_code(0);
    let listed = at_the_robot(&robot, &desk, "driver", &["list"]);
    assert!(listed.expect_code(0).out.contains("demo"), "{}", listed.out);
}

#[test]
fn streams_of_another_daemon_are_followed_through_this_one() {
    followed(fleet());
}

#[test]
fn streams_are_followed_with_zenoh_in_a_library_at_both_ends() {
    followed(fleet_on(IN_A_LIBRARY, IN_A_LIBRARY));
}

fn followed((robot, desk): (Daemon, Daemon)) {
    let token = robot.home().path().join("driver");
    let far = |arguments: &[&str]| {
        desk.spawn(&[&["--host", "zenoh:robot", "--token-file", path(&token)], arguments].concat())
    };
    // It was written at least when the activity ended.
    robot.ctl(&["start", "--wait", "demo", "goto", "goal=0.01"]).expect_code(0);
    let echo = far(&["--json", "echo", "demo/position"]);
    echo.line_where(|line| line.contains("0.01"));
    // The stream continues with later values.
    robot.ctl(&["start", "--wait", "demo", "goto", "goal=0.02"]).expect_code(0);
    echo.line_where(|line| line.contains("0.02"));
    echo.signal("INT");
    echo.finish().expect_code(0);
    // A recording is binary, and ends on request.
    let file = robot.home().path().join("far.mcap");
    let record = far(&["record", "-o", path(&file), "demo/position"]);
    record.error_line_where(|line| line.contains("recording to")).expect("it starts");
    robot.ctl(&["start", "--wait", "demo", "goto", "goal=0.03"]).expect_code(0);
    record.signal("INT");
    record.finish().expect_code(0);
    let recorded = std::fs::read(&file).unwrap();
    assert!(recorded.starts_with(b"\x89MCAP0\r\n") && recorded.ends_with(b"\x89MCAP0\r\n"));
    // The robot stops: its followers are notified.
    let echo = far(&["echo", "demo/position"]);
    echo.line_where(|line| line.contains("0.03"));
    robot.stop("TERM").0.expect_code(0);
    assert_ne!(echo.finish().code, Some(0));
}

#[test]
fn events_of_another_daemon_are_followed_through_this_one() {
    let (robot, desk) = fleet();
    let token = robot.home().path().join("watcher");
    let arguments = ["--host", "zenoh:robot", "--token-file", path(&token), "events"];
    let events = desk.spawn(&arguments);
    // Fired repeatedly, so that one of them comes after the desk has begun to listen.
    let (sender, first) = std::sync::mpsc::channel();
    let events = std::thread::scope(|scope| {
        scope.spawn(move || {
            let line = events.line();
            sender.send((events, line)).unwrap();
        });
        loop {
            robot.ctl(&["fire", "demo", "emergency"]).expect_code(0);
            if let Ok((events, line)) = first.try_recv() {
                assert_eq!(line, "event_fired component=demo name=emergency");
                break events;
            }
        }
    });
    // From then on everything arrives, in order.
    robot.ctl(&["start", "--wait", "demo", "goto", "goal=0.01"]).expect_code(0);
    events.line_where(|line| line.starts_with("activity_started component=demo"));
    events.line_where(|line| line.starts_with("activity_ended component=demo"));
    // The robot stops: its followers are notified, and the command ends.
    robot.stop("TERM").0.expect_code(0);
    events.line_where(|line| line == "stopping");
    events.finish().expect_code(3).expect_err("went away");
}

#[test]
fn the_live_table_shows_another_daemon() {
    let (robot, desk) = fleet();
    let once = at_the_robot(&robot, &desk, "watcher", &["top", "--once"]);
    assert!(once.expect_code(0).out.contains("demo/position"), "{}", once.out);
    robot.ctl(&["start", "--wait", "demo", "goto", "goal=0.01"]).expect_code(0);
    let token = robot.home().path().join("watcher");
    let arguments = ["--host", "zenoh:robot", "--token-file", path(&token), "top"];
    // It shows the robot's state, names the robot, and ends as on this machine.
    let steps = json!([
        {"wait": "zenoh:robot"}, {"wait": "demo/position"}, {"type": "p"}, {"wait": "paused"},
        {"type": "q"},
    ]);
    desk.on_terminal(100, &[], &steps, &arguments).expect_code(0);
}

#[test]
fn python_supervises_a_daemon_through_another_one() {
    let (robot, desk) = fleet();
    let script = "import genom, sys\n\
        with genom.connect('zenoh:robot', socket=sys.argv[1], token_file=sys.argv[2]) as g:\n\
        \x20   demo = g.component('demo')\n\
        \x20   demo.set_speed(0.25)\n\
        \x20   with g.events() as events:\n\
        \x20       demo.goto(0.0)\n\
        \x20       print(next(events)['component'], demo.get_speed())\n\
        try:\n\
        \x20   genom.connect('zenoh:robot', socket=sys.argv[1], token='x' * 32)\n\
        except genom.DaemonError as why:\n\
        \x20   print(why.name)\n";
    let (socket, token) = (desk.home().socket(), robot.home().path().join("driver"));
    let mut command = Command::new(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    command.env_clear().env("PYTHONPATH", repository().join("clients/python/src"));
    command.env("PYTHONDONTWRITEBYTECODE", "1").args(["-S", "-W", "error", "-c", script]);
    let ran = Running::start(command.args([path(&socket), path(&token)])).finish();
    ran.expect_code(0).expect_out("demo {'velocity': 0.25}\nnot_proved\n");
}

#[test]
fn a_second_daemon_of_one_name_is_told_so() {
    let memory = Arc::new(Memory::new());
    let arguments = ["--backend", "zenoh", "--daemon", "robot"];
    let _first = Home::with(&memory).start(&arguments);
    let home = Home::with(&memory);
    let second = home.spawn(&arguments);
    // Either at its start or when it discovers the first one.
    let told = second.error_line_where(|line| line.contains("another daemon named `robot`"));
    let told = told.expect("it says what is the matter");
    assert!(told.contains("reachable on zenoh") && told.contains("--daemon NAME"), "{told}");
    assert!(!told.contains("publisher"), "{told}");
}

#[test]
fn a_token_counts_over_zenoh_as_it_does_over_tcp() {
    let (robot, desk) = fleet();
    let call = ["call", "demo", "set_speed", "velocity=0.25"];
    at_the_robot(&robot, &desk, "watcher", &["list"]).expect_code(0);
    let refused = at_the_robot(&robot, &desk, "watcher", &call);
    refused.expect_code(1).expect_err("needs the right `call`; token watcher has read");
    let refused = desk.ctl(&["--host", "zenoh:robot", "list"]);
    refused.expect_code(1).expect_err("a token is needed here");
    // The desk has no token file: nobody may use it from outside.
    let token = robot.home().path().join("driver");
    let back = robot.ctl(&["--host", "zenoh:desk", "--token-file", path(&token), "list"]);
    back.expect_code(1).expect_err("does not know your token");
}

#[test]
fn a_daemon_that_is_not_there_is_told_so() {
    let (robot, desk) = fleet();
    at_the_robot(&robot, &desk, "driver", &["list"]).expect_code(0);
    let token = robot.home().path().join("driver");
    let lost = ["--host", "zenoh:robto", "--token-file", path(&token), "list"];
    let refused = desk.ctl(&lost);
    refused.expect_code(1).expect_err("no daemon `robto`").expect_err("did you mean `robot`?");
    let alone = Daemon::start(&[]);
    let refused = alone.ctl(&lost);
    refused.expect_code(1).expect_err("on no middleware").expect_err("--backend zenoh");
}

#[test]
fn components_of_two_daemons_are_connected_by_one_command() {
    let memory = Arc::new(Memory::new());
    let (writer, reader) = (component("demo-2010"), component("demo"));
    let writer = Home::with(&memory).start(&[
        "--backend",
        "zenoh",
        "--name",
        "paper",
        path(&writer.description),
    ]);
    // The reader is on another middleware; the address says where the writer is.
    let reader = Home::with(&memory).start(&["--backend", "local", path(&reader.library)]);
    reader.ctl(&["connect", "demo/parameter", "zenoh:paper/position"]).expect_code(0);
    writer.ctl(&["call", "paper", "goto", "position=0.5"]).expect_code(0);
    reader.ctl(&["connections"]).expect_code(0);
    let listed = reader.json(&["connections"]);
    assert_eq!(listed["connections"][0]["backend"], "zenoh", "{listed}");
}
