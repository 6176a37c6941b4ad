//! The figures of the two papers as printed: they run, with the transitions that the papers
//! describe (dialects.md A, B).

use genom_tests::{Daemon, Events, component, path};

fn figure(name: &str) -> Daemon {
    let figure = component(name);
    Daemon::start(&["--backend", "shm", path(&figure.description)])
}

/// States in the order in which they were entered, until the activity ended; without repetitions.
fn states(events: &mut Events) -> Vec<String> {
    let told = events.until(|e| e["event"] == "activity_ended");
    let mut states: Vec<String> = told
        .iter()
        .filter(|e| e["event"] == "transition")
        .map(|e| e["state"].as_str().unwrap().to_owned())
        .collect();
    states.dedup();
    states
}

#[test]
fn the_figure_of_2010_goes_from_start_to_main_to_stop() {
    let daemon = figure("demo-2010");
    assert_eq!(daemon.json(&["info", "demo"])["dialect"], "2010");
    let mut events = daemon.events();
    let called = daemon.ctl(&["call", "demo", "goto", r#"{"position":0.1}"#]);
    called.expect_code(0).expect_out("position = 0.1\n");
    assert_eq!(states(&mut events), ["main", "stop"]);
    assert_eq!(daemon.port("demo", "position")["value"], 0.1);
}

#[test]
fn the_figure_of_2011_goes_from_start_to_main_to_stop() {
    let daemon = figure("demo-2011");
    assert_eq!(daemon.json(&["info", "demo"])["dialect"], "2011");
    // The validation codel limits the speed to what the axis can do.
    let set = daemon.ctl(&["call", "demo", "setspeed", "velocity=50"]);
    set.expect_code(0).expect_out("velocity = 2.0\n");
    let mut events = daemon.events();
    daemon.ctl(&["call", "demo", "goto", "goal=0.1"]).expect_code(0);
    assert_eq!(states(&mut events), ["main", "stop"]);
    assert_eq!(daemon.port("demo", "position")["value"], 0.1);
}

#[test]
fn the_event_of_2010_puts_a_token_on_its_place_while_others_stay() {
    let daemon = figure("demo-2010");
    let mut events = daemon.events();
    let waiting = daemon.spawn(&["call", "demo", "goto", "position=0.5"]);
    events.wait_for(|e| e["state"] == "main");
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
    // Its codel runs in parallel with main, which continues to the goal: several states are active
    // at once.
    waiting.finish().expect_code(0).expect_out("position = 0.5\n");
    assert_eq!(states(&mut events).last().map(String::as_str), Some("stop"));
    let reply = daemon.json(&["stats", "demo"]);
    let codels = reply["codels"].as_array().unwrap();
    let stop = codels.iter().find(|codel| codel["name"] == "demo_stop").unwrap();
    assert_eq!(stop["durations"]["count"], 2, "{stop}");
}

#[test]
fn the_event_of_2011_needs_no_declaration() {
    let daemon = figure("demo-2011");
    assert_eq!(daemon.json(&["info", "demo"])["events"], serde_json::json!(["emergency"]));
    // No activity is waiting for it, so it has no effect.
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
}
