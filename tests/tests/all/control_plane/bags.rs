//! Bags of ROS 2, with a library of others that reads and writes them.

use std::path::Path;
use std::process::Command;

use genom_components::python;
use genom_tests::{Finished, Running, path, repository};
use serde_json::{Value, json};

use super::recording::{fed, motion, read};

fn rosbags(arguments: &[&str]) -> Finished {
    // As for the tests of `genomctl ros2-package`, so that there is one environment for both.
    let packages = ["rosbags==0.11.9", "ros-rosidl-adapter==4.6.6"];
    let python = python::environment(&packages).unwrap_or_else(|error| panic!("{error}"));
    let mut command = Command::new(python);
    command.arg(repository().join("tests/fixtures/bags.py")).args(arguments);
    Running::start(&mut command).finish()
}

/// What a bag has: type, count and samples of each topic.
fn content(bag: &Path) -> Value {
    let finished = rosbags(&["read", path(bag)]);
    finished.expect_code(0);
    serde_json::from_str(&finished.out).expect("JSON")
}

/// Dates and values of a recording's topic, as `content` has them.
fn recorded(topics: &Value, topic: &str) -> Value {
    let samples = topics[topic].as_array().expect(topic).iter();
    samples.map(|sample| json!([sample[0], sample[2]])).collect()
}

#[test]
fn a_bag_has_the_samples_of_a_recording_and_nothing_that_ros_does_not_know() {
    let (_, file, daemon) = fed();
    let bag = daemon.home().path().join("bag");
    let told = daemon.json(&["bag", path(&file), "-o", path(&bag)]);
    let topics = read(&file);
    let inside = content(&bag);
    let names: Vec<&String> = inside.as_object().unwrap().keys().collect();
    assert!(names.iter().all(|name| name.starts_with("/demo/")), "{names:?}");
    for topic in ["/demo/parameter", "/demo/position"] {
        let samples = recorded(&topics, topic);
        assert_eq!(inside[topic]["samples"], samples, "{topic}");
        assert_eq!(inside[topic]["count"], samples.as_array().unwrap().len());
    }
    assert_eq!(inside["/demo/position"]["type"], "demo/msg/State");
    let listed = told["topics"].as_array().unwrap().iter();
    let counts = |one: &Value| json!([one["topic"], one["type"], one["messages"]]);
    let expected = |topic: &&String| {
        let there = &inside[topic.as_str()];
        json!([topic, there["type"], there["count"]])
    };
    assert!(listed.map(counts).eq(names.iter().map(expected)), "{told}");
    let left_out = told["left_out"].as_array().unwrap();
    assert!(left_out.iter().any(|topic| topic == "/genom/activities"), "{told}");
    // The file alone is one, too.
    assert_eq!(content(&bag.join("samples_0.mcap"))["/demo/position"], inside["/demo/position"]);
}

#[test]
fn a_bag_of_others_is_replayed_and_gives_the_same_motion() {
    let (first, file, daemon) = fed();
    let place = |name: &str| daemon.home().path().join(name);
    let (bag, other, old) = (place("bag"), place("other"), place("old"));
    daemon.ctl(&["bag", path(&file), "-o", path(&bag)]).expect_code(0);
    rosbags(&["copy", path(&bag), path(&other), "mcap"]).expect_code(0);
    let (again, _, _daemon) = motion(|daemon| {
        let replayed = daemon.json(&["replay", "--step", path(&other)]);
        assert_eq!(replayed["ports"], json!([{"port": "demo/parameter", "published": 3}]));
    });
    assert_eq!(first, again);
    rosbags(&["copy", path(&bag), path(&old), "sqlite3"]).expect_code(0);
    let refused = daemon.ctl(&["replay", path(&old)]);
    refused.expect_code(1).expect_err("its format is sqlite3: `ros2 bag convert`");
}

#[test]
fn what_makes_no_bag_leaves_nothing_behind() {
    let (_, file, daemon) = motion(|_| {});
    let place = |name: &str| daemon.home().path().join(name);
    let bag = place("bag");
    let make = |from: &Path, to: &Path| daemon.ctl(&["bag", path(from), "-o", path(to)]);
    // Not a recording, and one that is damaged amid its samples.
    make(&place("genomd.toml"), &bag).expect_code(1).expect_err("no MCAP file");
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 3;
    bytes[middle..middle + 64].fill(0xA5);
    let damaged = place("damaged.mcap");
    std::fs::write(&damaged, bytes).unwrap();
    make(&damaged, &bag).expect_code(1).expect_err("damaged");
    assert!(!bag.exists());
    make(&file, &place("none/bag")).expect_code(1).expect_err("No such file or directory");
    make(&file, &bag).expect_code(0);
    make(&file, &bag).expect_code(2).expect_err("name another directory");
}
