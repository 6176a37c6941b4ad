//! The example configurations of several middlewares and machines: accepted as they are.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use genom_tests::{Home, component, path, repository};

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
