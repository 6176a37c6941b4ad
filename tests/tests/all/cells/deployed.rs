//! Deployments with cells: applied, dumped, pruned.

use genom_tests::{Daemon, Home};
use serde_json::json;

use super::{files, mission};

#[test]
fn a_dump_of_cells_brings_about_the_same_on_another_daemon() {
    let daemon = Home::new().configured(&mission("restart = \"always\"")).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let dump = daemon.ctl(&["dump"]).out;
    assert!(dump.contains("cell = \"base\"") && dump.contains("restart = \"always\""), "{dump}");
    let connections = daemon.json(&["connections"]);
    drop(daemon);
    let daemon = Daemon::start(&[]);
    let file = daemon.home().path().join("dump.toml");
    std::fs::write(&file, dump).unwrap();
    daemon.ctl(&["apply", genom_tests::path(&file)]).expect_code(0);
    assert_eq!(daemon.json(&["connections"]), connections);
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    // Applied again, nothing is to be done.
    let again = daemon.json(&["apply", genom_tests::path(&file)]);
    assert_eq!(again["steps"], json!([]));
}

#[test]
fn what_a_deployment_does_not_say_goes_from_cells_too_when_it_prunes() {
    let daemon = Home::new().configured(&mission("")).start(&[]);
    daemon.ctl(&["wait-ready", "--deployed"]).expect_code(0);
    let file = daemon.home().path().join("none.toml");
    std::fs::write(&file, "").unwrap();
    let beside = daemon.json(&["apply", genom_tests::path(&file)]);
    assert_eq!(beside["beside"], json!(["component demo", "component mission"]));
    daemon.ctl(&["apply", "--prune", genom_tests::path(&file)]).expect_code(0);
    assert_eq!(daemon.json(&["cells"])["cells"], json!([]));
    assert!(!files(&daemon).exists());
}

#[test]
fn a_component_of_the_daemon_itself_and_one_in_a_cell_are_wired_on_shared_memory() {
    let (demo, mission) = (genom_tests::component("demo"), genom_tests::component("mission"));
    let daemon = Daemon::start(&[genom_tests::path(&demo.library)]);
    daemon.ctl(&["load", "--isolated", genom_tests::path(&mission.library)]).expect_code(0);
    for (inport, outport) in [
        ("mission/position", "demo/position"),
        ("demo/parameter", "mission/gain"),
        ("mission/goto", "demo/goto"),
    ] {
        daemon.ctl(&["connect", inport, outport]).expect_code(0);
    }
    daemon.ctl(&["call", "mission", "patrol", "rounds=1"]).expect_code(0);
    let connections = daemon.json(&["connections"]);
    let all = connections["connections"].as_array().unwrap();
    assert!(all.iter().all(|one| one["backend"] == "shm"), "{connections}");
}
