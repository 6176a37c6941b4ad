//! What a daemon says of itself and of its cells together: recordings and metrics.

use genom_tests::{Daemon, Home, until};
use serde_json::Value;

use super::{load, signal};
use crate::control_plane::metrics::metrics;
use crate::control_plane::recording::{Recorder, read};

#[test]
fn a_recording_has_what_components_of_cells_write_and_are_asked() {
    let daemon = Daemon::demo("local");
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    let file = daemon.home().path().join("both.mcap");
    let recording = daemon.spawn(&["record", "-o", genom_tests::path(&file)]);
    recording.error_line_where(|line| line.contains("recording to"));
    for name in ["demo", "far"] {
        daemon.ctl(&["call", name, "goto", "goal=0.02"]).expect_code(0);
    }
    recording.signal("INT");
    recording.finish().expect_code(0);
    let mapped = std::fs::read(&file).unwrap();
    let mut messages = std::collections::BTreeMap::new();
    let mut calls = Vec::new();
    for message in mcap::MessageStream::new(&mapped).unwrap() {
        let message = message.unwrap();
        let topic = message.channel.topic.clone();
        if topic == "/genom/calls" {
            let call: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
            calls.push(call["component"].as_str().unwrap().to_owned());
        }
        *messages.entry(topic).or_insert(0) += 1;
    }
    assert!(messages["/demo/position"] > 1 && messages["/far/position"] > 1, "{messages:?}");
    calls.dedup();
    assert_eq!(calls, ["demo", "far"], "each asked and answered");
}

#[test]
fn a_recording_of_one_component_in_a_cell_has_nothing_of_others() {
    let daemon = Daemon::demo("local");
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    let file = daemon.home().path().join("far.mcap");
    let recording = daemon.spawn(&["record", "far/position", "-o", genom_tests::path(&file)]);
    recording.error_line_where(|line| line.contains("recording to"));
    for name in ["demo", "far"] {
        daemon.ctl(&["call", name, "goto", "goal=0.02"]).expect_code(0);
    }
    recording.signal("INT");
    recording.finish().expect_code(0);
    let mapped = std::fs::read(&file).unwrap();
    let topics: std::collections::BTreeSet<String> = mcap::MessageStream::new(&mapped)
        .unwrap()
        .map(|message| message.unwrap().channel.topic.clone())
        .collect();
    assert!(topics.contains("/far/position"), "{topics:?}");
    assert!(!topics.contains("/demo/position"), "{topics:?}");
    let refused = daemon.ctl(&["record", "far/nothing", "--force", "-o", genom_tests::path(&file)]);
    refused.expect_code(1).expect_err("far has no port `nothing`");
}

#[test]
fn what_a_component_in_a_cell_does_is_recorded_once_with_the_date_of_its_clock() {
    let daemon = Daemon::start(&["--clock", "virtual"]);
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    let recorder = Recorder::start(&daemon, "once.mcap", &[]);
    daemon.ctl(&["start", "far", "goto", "goal=0.005"]).expect_code(0);
    // The cell is stepped first: when it tells what happens at 5 ms, the daemon is at 4 ms still.
    for _ in 0..30 {
        daemon.ctl(&["step", "1ms"]).expect_code(0);
    }
    daemon.ctl(&["fire", "far", "emergency"]).expect_code(0);
    let topics = read(&recorder.end().1);
    let told = |topic: &str, keys: [&str; 2]| {
        let all = topics[topic].as_array().unwrap().iter().enumerate();
        let one = |(rank, one): (usize, &Value)| {
            assert_eq!(one[1], rank, "numbers of {topic}");
            let ms = one[0].as_u64().unwrap() as f64 / 1e6;
            format!("{ms} {}", keys.map(|key| one[2][key].to_string()).join(" "))
        };
        all.map(one).collect::<Vec<_>>()
    };
    let activities = told("/genom/activities", ["event", "paused"]);
    let wanted = ["0 \"activity_started\" null", "5 \"transition\" false", "5 \"transition\" true"];
    assert_eq!(activities, wanted);
    let changes = told("/genom/changes", ["event", "name"]);
    assert_eq!(changes, ["30 \"event_fired\" \"emergency\""]);
}

#[test]
fn a_recording_goes_on_with_the_next_process_of_a_cell() {
    let at_once = "[cells]\nrestart_delay = 0.0\n";
    let daemon = Home::new().configured(at_once).start(&["--backend", "local"]);
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    let file = daemon.home().path().join("far.mcap");
    let recording = daemon.spawn(&["record", "far", "-o", genom_tests::path(&file)]);
    recording.error_line_where(|line| line.contains("recording to"));
    daemon.ctl(&["call", "far", "goto", "goal=0.01"]).expect_code(0);
    signal(&daemon, "arm", "KILL");
    until("the recording goes on", || {
        daemon.ctl(&["logs"]).out.contains("a recording goes on with the next process of cell arm")
    });
    daemon.ctl(&["call", "far", "goto", "goal=0.02"]).expect_code(0);
    recording.signal("INT");
    recording.finish().expect_code(0);
    let mapped = std::fs::read(&file).unwrap();
    let mut calls = Vec::new();
    let mut numbers = Vec::new();
    for message in mcap::MessageStream::new(&mapped).unwrap() {
        let message = message.unwrap();
        match message.channel.topic.as_str() {
            "/genom/calls" => {
                let call: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
                calls.extend(call["inputs"]["goal"].as_f64());
            }
            "/far/position" => numbers.push(message.sequence),
            _ => {}
        }
    }
    calls.dedup();
    assert_eq!(calls, [0.01, 0.02]);
    // One channel of the port, whichever process wrote.
    let wanted: Vec<u32> = (0..numbers.len() as u32).collect();
    assert!(numbers.len() > 2 && numbers == wanted, "{numbers:?}");
}

#[test]
fn metrics_name_the_cell_of_a_component_and_how_often_it_started() {
    let daemon = Daemon::demo("local");
    load(&daemon, "demo", &["--name", "far", "--cell", "arm"]);
    let text = metrics(&daemon);
    for line in [
        "genom_cell_up{cell=\"arm\"} 1",
        "genom_cell_starts_total{cell=\"arm\"} 1",
        "genom_component{component=\"demo\",backend=\"local\"} 1",
        "genom_component{cell=\"arm\",component=\"far\",backend=\"shm\"} 1",
    ] {
        assert!(text.lines().any(|one| one == line), "{line}: {text}");
    }
    // Each family is described once (Prometheus refuses a page otherwise).
    let heads: Vec<_> = text.lines().filter(|line| line.starts_with("# HELP ")).collect();
    let unique: std::collections::BTreeSet<_> = heads.iter().collect();
    assert_eq!(heads.len(), unique.len());
}
