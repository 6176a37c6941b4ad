//! The demo, used through `genomd --backend B demo.so` and `genomctl`: with codels in C, and with codels
//! in Python and in Lua, in a cell of their own.

use genom_tests::{Daemon, component, path};
use serde_json::{Value, json};

/// Each rule for the codels in one language.
macro_rules! rules {
    ($language:ident, $demo:literal: $($rule:ident)*) => {
        mod $language {
            $(#[test]
            fn $rule() {
                super::$rule($demo);
            })*
        }
    };
}

/// The rules, for all languages.
macro_rules! all_rules {
    ($language:ident, $demo:literal) => {
        rules! { $language, $demo:
            the_demo_moves_to_its_goal_on_local
            the_demo_moves_to_its_goal_on_shared_memory
            the_demo_moves_to_its_goal_on_zenoh
            the_demo_moves_to_its_goal_on_ros2
            echo_follows_the_motion
            echo_ends_after_the_count_asked
            a_second_goto_stops_the_first_and_each_caller_is_told
            abort_runs_the_stop_codel
            abort_by_service_stops_all_its_activities
            ctrl_c_on_a_waiting_start_aborts_the_activity
            a_goal_out_of_range_is_an_exception_with_its_detail
            an_emergency_stands_the_axis_still
            info_reads_like_the_description
        }
    };
}

all_rules!(in_c, "demo");
all_rules!(in_python, "demo-py");
all_rules!(in_lua, "demo-lua");

/// Starts a daemon with this demo.
#[track_caller]
fn start(demo: &str, backend: &str) -> Daemon {
    Daemon::start(&["--backend", backend, path(&component(demo).library)])
}

/// Activity number that genomctl printed: `activity 3`.
fn number(line: &str) -> String {
    line.trim().strip_prefix("activity ").expect("an activity number").to_owned()
}

fn position(daemon: &Daemon) -> Value {
    daemon.port("demo", "position")["value"]["position"].clone()
}

/// Waits until the axis is so fast that it needs several periods to stop.
fn wait_until_fast(daemon: &Daemon) {
    let echo = daemon.spawn(&["echo", "demo/position", "--rate", "200"]);
    echo.line_where(|line| {
        let sample: Value = serde_json::from_str(line).unwrap();
        sample["velocity"].as_f64().unwrap().abs() > 0.2
    });
}

#[track_caller]
fn the_demo_moves_to_its_goal(demo: &str, backend: &str) {
    let daemon = start(demo, backend);
    daemon.ctl(&["call", "demo", "set_speed", r#"{"velocity":2.0}"#]).expect_code(0);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_code(0).expect_out("velocity = 2.0\n");
    daemon.ctl(&["start", "--wait", "demo", "goto", r#"{"goal":0.5}"#]).expect_code(0);
    assert_eq!(position(&daemon), 0.5);
    // The next one starts from there; inputs are words; `call` waits for activities, too.
    daemon.ctl(&["call", "demo", "goto", "goal=0.25"]).expect_code(0).expect_out("done\n");
    assert_eq!(position(&daemon), 0.25);
}

fn the_demo_moves_to_its_goal_on_local(demo: &str) {
    the_demo_moves_to_its_goal(demo, "local");
}

fn the_demo_moves_to_its_goal_on_shared_memory(demo: &str) {
    the_demo_moves_to_its_goal(demo, "shm");
}

fn the_demo_moves_to_its_goal_on_zenoh(demo: &str) {
    the_demo_moves_to_its_goal(demo, "zenoh");
}

fn the_demo_moves_to_its_goal_on_ros2(demo: &str) {
    the_demo_moves_to_its_goal(demo, "ros2");
}

fn echo_follows_the_motion(demo: &str) {
    let daemon = start(demo, "shm");
    let echo = daemon.spawn(&["echo", "demo/position", "--rate", "200"]);
    let first: Value = serde_json::from_str(&echo.line()).unwrap();
    assert_eq!(first, json!({"position": 0.0, "velocity": 0.0}));
    daemon.ctl(&["start", "demo", "goto", "goal=0.3"]).expect_code(0);
    let mut last = 0.0;
    let mut between = 0;
    loop {
        let sample: Value = serde_json::from_str(&echo.line()).unwrap();
        let position = sample["position"].as_f64().unwrap();
        assert!(position >= last, "{position} after {last}");
        last = position;
        if position == 0.3 && sample["velocity"] == 0.0 {
            break;
        }
        between += 1;
    }
    assert!(between > 3, "{between} samples on the way");
}

fn echo_ends_after_the_count_asked(demo: &str) {
    let daemon = start(demo, "local");
    let finished = daemon.ctl(&["echo", "-n", "1", "demo/position"]);
    finished.expect_code(0).expect_out("{\"position\":0.0,\"velocity\":0.0}\n");
}

fn a_second_goto_stops_the_first_and_each_caller_is_told(demo: &str) {
    let daemon = start(demo, "shm");
    let mut events = daemon.events();
    let first = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
    let moving = events.wait_for(|e| e["event"] == "transition" && e["state"] == "main");
    let one = moving["activity"].clone();
    wait_until_fast(&daemon);
    let second = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=0.1"]);

    // genom3.md 7.6: the first one runs its stop codel and ends before the second one starts.
    let told = events.until(|e| e["event"] == "activity_ended" && e["activity"] != one);
    let at = |wanted: &dyn Fn(&Value) -> bool| told.iter().position(wanted).expect("told");
    let stops = at(&|e| e["activity"] == one && e["state"] == "stop");
    let ends = at(&|e| e["activity"] == one && e["event"] == "activity_ended");
    let starts = at(&|e| e["activity"] != one && e["event"] == "transition");
    assert!(stops < ends && ends < starts, "{told:#?}");

    // genom3.md 7.5: an activity whose stop codel yields ether ends without an exception.
    first.finish().expect_code(0).expect_out("done\n");
    second.finish().expect_code(0).expect_out("done\n");
    assert_eq!(position(&daemon), 0.1);
}

fn abort_runs_the_stop_codel(demo: &str) {
    let daemon = start(demo, "shm");
    let mut events = daemon.events();
    let started = daemon.ctl(&["start", "demo", "goto", "goal=10"]);
    let activity = number(&started.out);
    wait_until_fast(&daemon);
    let list = daemon.json(&["activities", "demo"]);
    assert_eq!(list["activities"][0]["status"], "running", "{list}");
    let told = format!("activity {activity} told to stop\n");
    daemon.ctl(&["abort", "demo", &activity]).expect_code(0).expect_out(&told);
    events.wait_for(|e| e["event"] == "transition" && e["state"] == "stop");
    daemon.ctl(&["wait", "demo", &activity]).expect_code(0).expect_out("done\n");
    // The result can still be read; a second abort reports that the activity has ended.
    daemon.ctl(&["wait", "demo", &activity]).expect_code(0);
    daemon.ctl(&["abort", "demo", &activity]).expect_code(1).expect_err("already ended");
    assert!(position(&daemon).as_f64().unwrap() < 10.0);
}

fn abort_by_service_stops_all_its_activities(demo: &str) {
    let daemon = start(demo, "local");
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=-10"]);
    events.wait_for(|e| e["state"] == "main");
    daemon.ctl(&["abort", "demo", "goto"]).expect_code(0);
    waiting.finish().expect_code(0);
}

fn ctrl_c_on_a_waiting_start_aborts_the_activity(demo: &str) {
    let daemon = start(demo, "local");
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
    events.wait_for(|e| e["state"] == "main" && e["paused"] == true);
    waiting.signal("INT");
    events.wait_for(|e| e["event"] == "activity_ended");
    waiting.finish().expect_code(0);
}

fn a_goal_out_of_range_is_an_exception_with_its_detail(demo: &str) {
    let daemon = start(demo, "local");
    let finished = daemon.ctl(&["start", "demo", "goto", "goal=50"]);
    finished.expect_code(1).expect_out("");
    finished.expect_err("demo/goto ended with ::demo::OUT_OF_RANGE");
    finished.expect_err(r#"{"value":50.0,"lower":-10.0,"upper":10.0,"what":"goal, m"}"#);
    let finished = daemon.ctl(&["--json", "call", "demo", "set_speed", "velocity=9"]);
    finished.expect_code(1);
    let reply: Value = serde_json::from_str(&finished.out).unwrap();
    assert_eq!(reply["exception"], "::demo::OUT_OF_RANGE");
    assert_eq!(reply["detail"]["upper"], 2.0);
    // Nothing changed.
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.5\n");
}

fn an_emergency_stands_the_axis_still(demo: &str) {
    let daemon = start(demo, "local");
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["start", "--wait", "demo", "goto", "goal=10"]);
    events.wait_for(|e| e["state"] == "main" && e["paused"] == true);
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
    waiting.finish().expect_code(1).expect_err("::demo::HALTED");
}

#[test]
fn rust_codels_do_the_same() {
    let daemon = start("demo-rs", "shm");
    daemon.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.2"]).expect_code(0).expect_out("done\n");
    assert_eq!(position(&daemon), 0.2);
    daemon.ctl(&["call", "demo", "goto", "goal=11"]).expect_code(1).expect_err("OUT_OF_RANGE");
}

fn info_reads_like_the_description(demo: &str) {
    let daemon = start(demo, "local");
    let shown = daemon.ctl(&["info", "demo", "goto"]);
    shown.expect_code(0);
    for wanted in ["activity goto(in double goal = 1.0)", "goal: Position to reach, m", "task main"]
    {
        assert!(shown.out.contains(wanted), "expected `{wanted}` in:\n{}", shown.out);
    }
    let listed = daemon.ctl(&["list"]);
    assert!(listed.out.starts_with("NAME  COMPONENT  STATE"), "{}", listed.out);
    let stats = daemon.json(&["stats", "demo"]);
    assert_eq!(stats["tasks"][0]["name"], "main");
    assert_eq!(stats["tasks"][0]["period_ns"], 5_000_000);
}
