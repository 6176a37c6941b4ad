//! What is done of other components when the cell of one ends by a fault.

use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::{Value, json};

use super::{cell, signal};

/// A demo where `of_demo` says, and a component in cell `arm` that `on_failure` is of.
fn robot(of_demo: &str, of_arm: &str, on_failure: &str) -> String {
    let (demo, crashes) = (component("demo").library, component("crashes").library);
    format!(
        "[[component]]\nlibrary = {demo:?}\n{of_demo}\n\
         [[component]]\nlibrary = {crashes:?}\nname = \"arm\"\ncell = \"arm\"\n{of_arm}\n\
         {on_failure}\n"
    )
}

const SLOW_DOWN: &str =
    "[component.on_failure]\ncall = \"demo/set_speed\"\ninputs = { velocity = 0.5 }\n";

#[track_caller]
fn speed(daemon: &Daemon) -> Value {
    daemon.json(&["call", "demo", "get_speed"])["result"]["velocity"].clone()
}

#[test]
fn the_safe_state_is_entered_before_the_cell_that_failed_starts_again() {
    let several = "[[component.on_failure]]\ncall = \"demo/set_speed\"\n\
                   inputs = { velocity = 0.5 }\n\
                   [[component.on_failure]]\nfire = \"demo/emergency\"\n\
                   [[component.on_failure]]\nstart = \"demo/goto\"\ninputs = { goal = 0.25 }\n";
    let slow = "[cells]\nrestart_delay = 3600.0\nrestart_delay_max = 3600.0\n";
    let daemon = Home::new().configured(&(robot("", "", several) + slow)).start(&[]);
    let mut events = daemon.events();
    daemon.ctl(&["call", "arm", "segfault"]).expect_code(1);
    let mut done: Vec<String> = (0..3)
        .map(|_| {
            let told = events.wait_for(|e| e["event"] == "failure_reaction");
            assert_eq!((&told["component"], &told["error"]), (&json!("arm"), &Value::Null));
            told["reaction"].as_str().unwrap().to_owned()
        })
        .collect();
    done.sort();
    assert_eq!(done, ["call demo/set_speed", "fire demo/emergency", "start demo/goto"]);
    assert_eq!(speed(&daemon), json!(0.5));
    // It is done before the report, the end of what the cell left, and all else.
    until("the cell waits", || cell(&daemon, "arm")["state"] == "waiting");
}

#[test]
fn a_cell_that_is_to_start_at_once_starts_after_the_safe_state() {
    let at_once = "[cells]\nrestart_most = 1000\nrestart_delay = 0.0\n";
    let elsewhere = robot("cell = \"base\"", "", SLOW_DOWN) + at_once;
    let daemon = Home::new().configured(&elsewhere).start(&[]);
    let mut events = daemon.events();
    for _ in 0..5 {
        signal(&daemon, "arm", "KILL");
        let next = |event: &Value| {
            let runs = event["event"] == "cell_runs" && event["cell"] == "arm";
            runs || event["event"] == "failure_reaction"
        };
        let told = events.wait_for(next);
        assert_eq!((&told["event"], &told["error"]), (&json!("failure_reaction"), &Value::Null));
        assert_eq!(events.wait_for(next)["event"], "cell_runs");
    }
}

#[test]
fn a_component_in_another_cell_is_reached_as_well_and_the_next_daemon_knows_what_to_do() {
    let never = "restart = \"never\"";
    let home = Home::new().configured(&robot("cell = \"base\"", never, SLOW_DOWN));
    let daemon = home.start(&[]);
    let dumped = daemon.ctl(&["dump"]).out;
    assert!(dumped.contains("[[component.on_failure]]") && dumped.contains("demo/set_speed"));
    let home = daemon.abandon();
    // Without its components: what is to be done for a cell is in its journal.
    let file = home.path().join("genomd.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, &text[text.find("[backends").unwrap()..]).unwrap();
    let daemon = home.start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let mut events = daemon.events();
    signal(&daemon, "arm", "KILL");
    let told = events.wait_for(|e| e["event"] == "failure_reaction");
    assert_eq!((&told["reaction"], &told["error"]), (&json!("call demo/set_speed"), &Value::Null));
    assert_eq!(speed(&daemon), json!(0.5));
}

#[test]
fn what_cannot_be_done_is_told_as_an_error_with_the_way_out() {
    let daemon = Daemon::demo("local");
    let mut events = daemon.events();
    for (name, on_failure, why) in [
        ("a", json!({"call": "base/stop"}), "base does not run"),
        ("b", json!({"start": "demo/gotto"}), "did you mean `goto`?"),
        ("c", json!({"fire": "demo/emergencies"}), "did you mean `emergency`?"),
        ("d", json!({"call": "demo/goto", "inputs": {"goal": 1e9}}), "::demo::OUT_OF_RANGE"),
    ] {
        let library = component("crashes").library;
        let load = json!({
            "library": library, "name": name, "cell": name, "restart": "never",
            "on_failure": on_failure,
        });
        let loaded = request(&daemon.home().socket(), "POST", "/components", &load.to_string());
        assert_eq!(loaded.status, 201, "{loaded:?}");
        signal(&daemon, name, "KILL");
        let told = events.wait_for(|e| e["event"] == "failure_reaction" && e["component"] == name);
        let error = told["error"].as_str().unwrap();
        assert!(error.contains(why), "{error}");
        let log = daemon.ctl(&["logs"]).out;
        let line = log.lines().find(|line| line.contains(why)).expect("an entry of the log");
        assert!(line.contains("ERROR") && line.contains("change [component.on_failure]"), "{line}");
    }
}

#[test]
fn a_component_that_is_loaded_by_hand_may_have_a_safe_state_as_well() {
    let daemon = Daemon::demo("local");
    let library = component("crashes").library;
    let safe =
        ["--on-failure", "call demo/set_speed velocity=0.5", "--on-failure", "fire demo/emergency"];
    let arm = ["load", path(&library), "--name", "arm", "--isolated", "--restart", "never"];
    daemon.ctl(&[&arm[..], &["--on-failure", "stop demo"]].concat()).expect_code(2);
    daemon.ctl(&[&arm[..], &safe].concat()).expect_code(0);
    let mut events = daemon.events();
    signal(&daemon, "arm", "KILL");
    for _ in 0..2 {
        let told = events.wait_for(|e| e["event"] == "failure_reaction");
        assert_eq!(told["error"], Value::Null);
    }
    assert_eq!(speed(&daemon), json!(0.5));
}

#[test]
fn what_could_never_be_done_is_refused_before_anything_runs() {
    for (of_demo, on_failure, why) in [
        ("", "call = \"demo/set_spede\"", "demo has no service `set_spede`; did you mean"),
        ("", "start = \"demo/set_speed\"", "demo/set_speed is no activity: say `call`"),
        ("", "fire = \"demo/fire\"", "demo has no event `fire`"),
        ("", "call = \"dmo/goto\"", "no component `dmo` runs or is deployed here; did you mean"),
        ("cell = \"arm\"", "fire = \"demo/emergency\"", "demo runs in cell arm, too"),
    ] {
        let on_failure = format!("[component.on_failure]\n{on_failure}\n");
        let text = robot(of_demo, "", &on_failure);
        let home = Home::new().configured(&text);
        home.refused(&["--check"]).expect_code(1).expect_err(why);
        home.refused(&[]).expect_code(2).expect_err("component.on_failure").expect_err(why);
        let daemon = Daemon::start(&[]);
        let file = home.path().join("robot.toml");
        std::fs::write(&file, &text).unwrap();
        let refused = daemon.ctl(&["apply", "--dry-run", path(&file)]);
        refused.expect_code(1).expect_err(why);
    }
    let home = Home::new().configured(&robot("", "", "[component.on_failure]\ncall = \"demo\"\n"));
    home.refused(&[]).expect_code(2).expect_err("`demo` is no COMPONENT/NAME");
}
