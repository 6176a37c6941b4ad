//! The example configurations of several middlewares and machines: accepted, and run.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use genom_tests::{Home, component, path, repository};
use serde_json::Value;

fn text(name: &str) -> String {
    std::fs::read_to_string(repository().join("configs").join(name)).unwrap()
}

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
            arguments.extend(["--set", "backends.zenoh.connect=[\"tcp/192.168.1.10:7447\"]"]);
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

#[test]
fn components_on_several_middlewares_run_in_one_daemon() {
    let home = Home::new().configured(&text("mixed.toml"));
    let daemon = home.start(&["--path", &demo_folder()]);
    let listed = daemon.json(&["backends", "--visible"]);
    let seen = |backend: &str, address: &str| {
        let middlewares = listed["middlewares"].as_array().unwrap();
        let found = middlewares.iter().find(|one| one["name"] == backend).unwrap();
        let ends = found["endpoints"].as_array().cloned().unwrap_or_default();
        // Tests have a namespace each, which comes first.
        let is = |end: &Value| {
            let shown = end["address"].as_str().unwrap();
            shown
                .strip_suffix(address)
                .is_some_and(|first| first.is_empty() || first.ends_with('/'))
        };
        ends.iter().any(|end| end["kind"] == "publisher" && is(end))
    };
    for (address, on) in [
        ("wheels/position", &["shm", "ros2"][..]),
        ("mast/position", &["zenoh"]),
        ("trial/position", &["local"]),
    ] {
        for backend in ["local", "shm", "zenoh", "ros2"] {
            assert_eq!(seen(backend, address), on.contains(&backend), "{address} on {backend}");
        }
    }
    for instance in ["wheels", "mast", "trial"] {
        daemon.ctl(&["start", "--wait", instance, "goto", "goal=0.25"]).expect_code(0);
        let position: &Value = &daemon.port(instance, "position")["value"]["position"];
        assert_eq!(*position, serde_json::json!(0.25), "{instance}");
    }
}
