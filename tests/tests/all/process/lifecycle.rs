//! Starting, stopping, being killed: nothing stays behind, and nothing blocks the next start.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;

use genom_tests::{Daemon, Home, component, path};

fn left(home: &Home) -> Vec<PathBuf> {
    let mut left = home.memory().files();
    left.extend(fs::read_dir(home.socket().parent().unwrap()).unwrap().map(|e| e.unwrap().path()));
    left
}

#[track_caller]
fn a_signal_stops_it_cleanly(signal: &str) {
    let daemon = Daemon::demo("shm");
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
    let moving = events.wait_for(|e| e["state"] == "main" && e["paused"] == true);
    assert!(!daemon.home().memory().files().is_empty());
    // So fast that it needs several periods to stop.
    let echo = daemon.spawn(&["echo", "demo/position", "--rate", "200"]);
    echo.line_where(|line| {
        let sample: serde_json::Value = serde_json::from_str(line).unwrap();
        sample["velocity"].as_f64().unwrap() > 0.2
    });
    drop(echo);
    let (stopped, home) = daemon.stop(signal);
    stopped.expect_code(0);
    // The activity was interrupted, its stop codel ran, and its caller got the reply.
    events.wait_for(|e| e["activity"] == moving["activity"] && e["state"] == "stop");
    events.wait_for(|e| e["event"] == "activity_ended" && e["activity"] == moving["activity"]);
    events.wait_for(|e| e["event"] == "component_unloaded");
    waiting.finish().expect_code(0).expect_out("done\n");
    assert_eq!(left(&home), Vec::<PathBuf>::new());
}

#[test]
fn sigterm_stops_it_cleanly() {
    a_signal_stops_it_cleanly("TERM");
}

#[test]
fn sigint_stops_it_cleanly() {
    a_signal_stops_it_cleanly("INT");
}

#[test]
fn sighup_that_somebody_sends_stops_it_cleanly() {
    a_signal_stops_it_cleanly("HUP");
}

#[test]
fn kill_returns_when_nothing_is_left() {
    let daemon = Daemon::demo("shm");
    daemon.ctl(&["kill"]).expect_code(0).expect_out("stopped\n");
    assert_eq!(left(daemon.home()), Vec::<PathBuf>::new());
    daemon.ctl(&["list"]).expect_code(3);
}

#[test]
fn after_kill_9_it_starts_again() {
    let daemon = Daemon::demo("shm");
    daemon.ctl(&["call", "demo", "goto", "goal=0.1"]).expect_code(0);
    let (stopped, home) = daemon.stop("KILL");
    assert_eq!(stopped.code, None);
    assert!(home.socket().exists(), "a killed daemon leaves its socket");
    let demo = component("demo");
    let daemon = home.start(&["--backend", "shm", path(&demo.library)]);
    let first = daemon.ctl(&["echo", "-n", "1", "demo/position"]);
    first.expect_code(0).expect_out("{\"position\":0.0,\"velocity\":0.0}\n");
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert_eq!(left(&home), Vec::<PathBuf>::new());
}

#[test]
fn a_live_socket_is_refused_and_private() {
    let daemon = Home::new().start(&[]);
    let refused = daemon.home().refused(&[]);
    refused.expect_code(3).expect_err("a genomd already listens on");
    let mode = fs::metadata(daemon.home().socket()).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    daemon.ctl(&["list"]).expect_code(0);
}

#[test]
fn components_come_and_go_while_it_runs() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    daemon.ctl(&["list"]).expect_code(0).expect_out("");
    let demo = component("demo");
    for _ in 0..3 {
        daemon.ctl(&["load", path(&demo.library), "--name", "arm"]).expect_code(0);
        daemon.ctl(&["call", "arm", "goto", "goal=0.01"]).expect_code(0);
        daemon.ctl(&["unload", "arm"]).expect_code(0).expect_out("arm unloaded\n");
        daemon.ctl(&["info", "arm"]).expect_code(1);
    }
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(0);
    assert_eq!(left(&home), Vec::<PathBuf>::new());
}

#[test]
fn an_echo_ends_when_its_component_is_unloaded() {
    let daemon = Daemon::demo("local");
    let echo = daemon.spawn(&["echo", "demo/position"]);
    echo.line();
    daemon.ctl(&["unload", "demo"]).expect_code(0);
    echo.finish().expect_code(1).expect_err("demo/position is no more");
}

#[test]
fn service_kill_unloads_the_component() {
    let daemon = Daemon::demo("local");
    let mut events = daemon.events();
    daemon.ctl(&["call", "demo", "kill"]).expect_code(0);
    events.wait_for(|e| e["event"] == "component_unloaded" && e["component"] == "demo");
    daemon.ctl(&["list"]).expect_code(0).expect_out("");
}

#[test]
fn several_components_run_in_one_daemon() {
    let (demo, rust) = (component("demo"), component("demo-rs"));
    let home = Home::new();
    let config = format!(
        "backend = \"local\"\n[[component]]\nlibrary = {:?}\nname = \"arm\"\n\
         [[component]]\nlibrary = {:?}\nname = \"wrist\"\n",
        demo.library, rust.library
    );
    fs::write(home.path().join("genomd.toml"), config).unwrap();
    let daemon = home.start(&[path(&demo.library)]);
    let list = daemon.json(&["list"]);
    let names: Vec<_> =
        list["components"].as_array().unwrap().iter().map(|c| c["name"].clone()).collect();
    assert_eq!(names, ["arm", "wrist", "demo"]);
    for name in ["arm", "wrist", "demo"] {
        daemon.ctl(&["call", name, "goto", "goal=0.02"]).expect_code(0);
    }
}

#[test]
fn components_are_found_on_the_component_path() {
    let demo = component("demo");
    let components = demo.library.parent().unwrap().parent().unwrap();
    let daemon = Home::new().start(&["--path", path(components), "demo", "--name", "arm"]);
    daemon.ctl(&["load", "demo", "--name", "other"]).expect_code(0);
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 2);
}

#[test]
fn version_tells_the_middlewares() {
    let told = Home::new().refused(&["--version"]);
    told.expect_code(0);
    for wanted in ["genomd ", "backend local (", "backend shm (iceoryx2 0.10)"] {
        assert!(told.out.contains(wanted), "{}", told.out);
    }
}
