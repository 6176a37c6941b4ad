//! A daemon whose process is stopped: its clients report that after a timeout. A slow daemon is
//! waited for.

use std::time::Instant;

use genom_tests::fleet::{at_the_robot, fleet};
use genom_tests::{Daemon, fixture, until};
use serde_json::Value;

/// How long genomctl waits for a stopped daemon, in seconds.
const MOMENT: &str = "0.4";
/// The same for a running one on a busy machine.
const LONG: &str = "5";

#[test]
fn a_daemon_that_is_stopped_is_told_by_every_kind_of_verb() {
    let daemon = Daemon::demo("local");
    // Opened before, and silent from then on.
    let stream = daemon.spawn(&["--timeout", LONG, "echo", "demo/parameter"]);
    let events = daemon.spawn(&["--timeout", LONG, "events"]);
    let home = daemon.home().path().to_owned();
    let file = home.join("run.mcap");
    let recorder = ["--timeout", LONG, "record", "-o", file.to_str().unwrap(), "demo"];
    let recorder = daemon.spawn(&recorder);
    let told = recorder.error_line_where(|line| line.starts_with("recording to"));
    assert!(told.is_some(), "the recording begins");
    until("both streams and the recording are open", || open_sockets(&daemon) >= 3);
    daemon.process().signal("STOP");
    let stopped = format!("its process {} is stopped", daemon.process().id());
    for arguments in [
        &["list"][..],
        &["call", "demo", "get_speed"],
        &["start", "--wait", "demo", "goto", "goal=1"],
        &["events"],
        &["top", "--once"],
        &["kill"],
    ] {
        let given_up = daemon.ctl(&[&["--timeout", MOMENT], arguments].concat());
        given_up.expect_code(3).expect_err(&stopped);
        given_up.expect_err(&format!("kill -CONT {}", daemon.process().id()));
    }
    for running in [stream, events] {
        running.finish().expect_code(3).expect_err(&stopped);
    }
    recorder.finish().expect_code(3).expect_err(&stopped);
    let told = daemon.ctl(&["--json", "--timeout", MOMENT, "list"]);
    let told: Value = serde_json::from_str(&told.err).expect("one line of JSON");
    assert_eq!(told["error"]["code"], "silent");
    daemon.process().signal("CONT");
    daemon.ctl(&["list"]).expect_code(0);
}

/// Number of connections that the daemon has open on its socket.
fn open_sockets(daemon: &Daemon) -> usize {
    let all = std::fs::read_to_string("/proc/net/unix").unwrap();
    let socket = daemon.home().socket();
    let name = format!(" {}", socket.display());
    // 03: connected.
    all.lines().filter(|line| line.contains(&name) && line.contains(" 03 ")).count()
}

#[test]
fn a_daemon_that_is_stopped_is_given_up_over_a_middleware_too() {
    let (robot, desk) = fleet();
    let ask = |arguments: &[&str]| at_the_robot(&robot, &desk, "watcher", arguments);
    until("the robot is seen", || ask(&["list"]).code == Some(0));
    robot.process().signal("STOP");
    let given_up = ask(&["--timeout", LONG, "list"]);
    given_up.expect_code(3).expect_err("robot");
    robot.process().signal("CONT");
    until("the robot answers again", || ask(&["list"]).code == Some(0));
}

#[test]
fn a_service_may_take_longer_than_an_answer() {
    let scratch = tempfile::tempdir().unwrap();
    let daemon = Daemon::start(&[&fixture("gains", "gains", scratch.path())]);
    let begin = Instant::now();
    let slow = daemon.spawn(&["--timeout", LONG, "call", "gains", "set_slowly", "all.a=5"]);
    until("the service lasts longer", || {
        daemon.ctl(&["call", "gains", "waits"]).expect_code(0);
        begin.elapsed().as_secs_f64() > 1.2 * LONG.parse::<f64>().unwrap()
    });
    daemon.ctl(&["call", "gains", "release"]).expect_code(0);
    slow.finish().expect_code(0).expect_out("done\n");
}
