//! The simulated quadrotor of `configs/sim-quadrotor.toml`: MuJoCo, and a controller in C.

use serde_json::Value;

use super::simulated::{deployed, deployment};
use crate::control_plane::recording::{Recorder, read};

/// Where it is sent.
const GOAL: &str = r#"goal={"x": 1.0, "y": 0.5, "z": 1.5}"#;

/// What the simulator and the controller published in a flight of 6 s from the ground to a place.
fn flight(backend: &str) -> [Value; 2] {
    let text = deployment("sim-quadrotor.toml", &["hover"]);
    let daemon = deployed(&text, &["--clock", "virtual", "--backend", backend]);
    let recorder = Recorder::start(&daemon, "run.mcap", &["sim", "hover"]);
    let go = daemon.json(&["start", "hover", "go", GOAL]);
    for _ in 0..60 {
        daemon.ctl(&["step", "100ms"]).expect_code(0);
    }
    let reply = daemon.json(&["activities", "hover"]);
    let activities = reply["activities"].as_array().unwrap();
    let ended = activities.iter().find(|one| one["activity"] == go["activity"]).unwrap();
    assert_eq!(ended["status"], "done", "{ended}");
    let (_, file) = recorder.end();
    let topics = read(&file);
    ["/sim/base", "/hover/command"].map(|topic| topics[topic].clone())
}

/// A vector of a message of a recording.
fn vector<const N: usize>(message: &Value, member: &str) -> [f64; N] {
    let numbers = message[2][member].as_array().unwrap().iter().flat_map(Value::as_f64);
    numbers.collect::<Vec<_>>().try_into().unwrap()
}

#[test]
fn a_simulated_quadrotor_flies_from_the_ground_to_a_place_and_stays_there_the_same_in_each_run() {
    let first = flight("local");
    let [base, command] = &first;
    let base = base.as_array().unwrap();
    assert_eq!(base.len(), 6000, "one a millisecond");
    let [_, _, ground] = vector(&base[0], "position");
    assert!((0.0..0.06).contains(&ground), "{ground} m above the ground");
    for message in &base[5000..] {
        let [x, y, z]: [f64; 3] = vector(message, "position");
        let [ahead, left, up] = [x - 1.0, y - 0.5, z - 1.5].map(f64::abs);
        assert!(ahead < 0.01 && left < 0.01 && up < 0.02, "{message}");
    }
    // It neither turns over on its way, nor about its vertical axis.
    for message in base {
        let [w, x, y, z]: [f64; 4] = vector(message, "attitude");
        assert!(w.abs() > 0.95 && z.abs() < 0.02, "{w} {x} {y} {z}");
    }
    for message in command.as_array().unwrap() {
        let thrusts: [f64; 4] = vector(message, "effort");
        assert!(thrusts.iter().all(|thrust| (0.0..=6.0).contains(thrust)), "{thrusts:?}");
    }
    assert!(first == flight("local"), "two runs differ");
    assert!(first == flight("shm"), "a run on shm differs");
}

#[test]
fn a_quadrotor_that_is_sent_nowhere_stays_where_it_is() {
    let text = deployment("sim-quadrotor.toml", &["hover"]);
    let daemon = deployed(&text, &["--clock", "virtual"]);
    let refused = daemon.json(&["start", "hover", "go", GOAL, "tolerance=0"]);
    daemon.ctl(&["step", "500ms"]).expect_code(0);
    let reply = daemon.json(&["activities", "hover"]);
    let activities = reply["activities"].as_array().unwrap();
    let ended = activities.iter().find(|one| one["activity"] == refused["activity"]).unwrap();
    assert_eq!(ended["exception"], "::hover::NO_PLACE", "{ended}");
    let position = &daemon.port("sim", "base")["value"]["position"];
    for (at, wanted) in [0.0, 0.0, 0.05].iter().enumerate() {
        assert!((position[at].as_f64().unwrap() - wanted).abs() < 0.02, "{position}");
    }
}
