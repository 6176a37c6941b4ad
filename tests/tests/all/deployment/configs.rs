//! The example configurations for several middlewares and machines are accepted as they are.

use std::path::Path;
use std::sync::Arc;

use genom_tests::{Home, Memory, component, path, repository};

fn demo_folder() -> String {
    path(component("demo").library.parent().unwrap()).to_owned()
}

#[test]
fn two_machines_take_their_parts_of_one_file() {
    let folder = demo_folder();
    for (daemon, instance) in [("base", "wheels"), ("station", "replica")] {
        let home = Home::new();
        let file = repository().join("configs/two-machines.toml");
        std::fs::copy(file, home.path().join("genomd.toml")).unwrap();
        let mut arguments = vec!["--daemon", daemon, "--path", folder.as_str()];
        if daemon == "station" {
            arguments.extend(["--set", "backends.zenoh.listen=[]"]);
            arguments.extend(["--set", "backends.zenoh.connect=[\"tls/192.168.1.10:7447\"]"]);
        }
        let checked = home.refused(&[&arguments[..], &["--check"]].concat());
        checked.expect_code(0);
        assert_eq!(checked.out.matches(" fits ").count(), 1, "{}", checked.out);
        let dumped = home.refused(&[&arguments[..], &["--dump-config"]].concat());
        dumped.expect_code(0);
        let table: toml::Table = dumped.out.parse().expect("TOML");
        let part = table["component"]
            .as_array()
            .unwrap()
            .iter()
            .find(|one| one.get("daemon").and_then(toml::Value::as_str) == Some(daemon));
        assert_eq!(part.unwrap()["name"].as_str(), Some(instance));
        let ends = if daemon == "base" { (1, 0) } else { (0, 1) };
        let zenoh = &table["backends"]["zenoh"];
        let count = |key: &str| zenoh[key].as_array().unwrap().len();
        assert_eq!((count("listen"), count("connect")), ends);
    }
}

/// A component on ROS 2 with a QoS of its own for one port.
fn on_ros2(library: &Path, name: &str, port: &str, quality: &str) -> String {
    format!(
        "backend = \"ros2\"\n[[component]]\nlibrary = {library:?}\nname = \"{name}\"\n\
         [component.qos.ports.{port}]\n{quality}\n"
    )
}

#[test]
fn quality_that_does_not_fit_is_told_by_why_and_by_doctor() {
    let memory = Arc::new(Memory::new());
    let (paper, demo) = (component("demo-2010"), component("demo"));
    let text = on_ros2(&paper.description, "paper", "position", "reliable = false");
    let writer = Home::with(&memory).configured(&text);
    let dumped = writer.refused(&["--dump-config"]);
    let table: toml::Table = dumped.out.parse().expect("TOML");
    assert_eq!(table["component"][0]["qos"]["ports"]["position"]["reliable"], false.into());
    let _writer = writer.start(&[]);
    let text = on_ros2(&demo.library, "demo", "parameter", "reliable = true");
    let reader = Home::with(&memory).configured(&text).start(&[]);
    // The QoS is visible when the port is connected.
    reader.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    let told = reader.ctl(&["why", "demo/parameter"]);
    let what = "a writer of paper/position on ros2 offers best effort, and the in port asks for \
                reliable\n  fix: leave that out of [component.qos.ports.parameter], or say \
                `reliable = false` there\n";
    assert!(told.out.contains(what), "{}", told.out);
    let doctor = reader.ctl(&["doctor"]);
    assert!(doctor.out.contains("problem  ports: a writer of paper/position"), "{}", doctor.out);
}

#[test]
fn values_published_from_outside_have_the_quality_of_their_port() {
    let memory = Arc::new(Memory::new());
    let demo = component("demo");
    let text = on_ros2(&demo.library, "demo", "parameter", "reliable = false");
    let fed = Home::with(&memory).configured(&text).start(&[]);
    fed.ctl(&["pub", "demo/parameter", "0.5"]).expect_code(0);
    let text = on_ros2(&demo.library, "reader", "parameter", "reliable = true");
    let reader = Home::with(&memory).configured(&text).start(&[]);
    reader.ctl(&["connect", "reader/parameter", "demo/parameter"]).expect_code(0);
    let told = reader.ctl(&["why", "reader/parameter"]);
    let what = "a writer of demo/parameter on ros2 offers best effort, and the in port asks for \
                reliable";
    assert!(told.out.contains(what), "{}", told.out);
}

#[test]
fn mistakes_in_the_quality_of_ports_name_file_line_and_what_was_meant() {
    let demo = component("demo");
    for (port, quality, told) in [
        ("position", "reliable = \"best_efort\"", "genomd.toml:6: `reliable` is true or false"),
        ("position", "dept = 3", "genomd.toml:6: unknown field `dept`"),
        ("positon", "depth = 3", "genomd.toml:5: component.qos.ports.positon: demo/positon"),
        ("parameter", "depth = 3", "genomd.toml:5: component.qos.ports.parameter: demo/parameter"),
    ] {
        let home = Home::new().configured(&on_ros2(&demo.library, "demo", port, quality));
        let refused = home.refused(&[]);
        assert!(refused.err.contains(told), "{}", refused.err);
    }
}
