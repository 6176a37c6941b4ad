//! The project's own scenarios pass, the same way each time.

use std::fs;

use genom_tests::{WATCHDOG, path, until};
use serde_json::Value;

use super::{Place, scenarios, steps};

#[track_caller]
fn pass(backend: &str, axis: &str) {
    let place = Place::new();
    place.link("mission", "mission");
    if axis != "demo" {
        fs::remove_dir_all(place.path("lib")).unwrap();
        place.link(axis, "demo");
    }
    // Other languages have the same axis; the mission is in C.
    let file = if axis == "demo" { scenarios() } else { scenarios().join("axis.toml") };
    let lib = place.path("lib");
    let run = |report: &str| {
        let report = place.path(report);
        let arguments =
            [path(&file), "--path", path(&lib), "--backend", backend, "--junit", path(&report)];
        let told = place.start(&arguments).finish_within(3 * WATCHDOG);
        told.expect_code(0);
        assert!(!told.out.contains("FAIL"), "{}", told.out);
        (told.out, fs::read(report).unwrap())
    };
    let first = run("1.xml");
    // Scripts are in a cell: stepping another process takes several times as long.
    if !["demo-py", "demo-lua"].contains(&axis) {
        assert_eq!(first, run("2.xml"));
    }
    assert!(place.left().is_empty(), "{:?}", place.left());
}

#[test]
fn the_scenarios_of_the_project_pass_on_local_and_two_runs_give_the_same_bytes() {
    pass("local", "demo");
}

#[test]
fn the_scenarios_of_the_project_pass_on_shared_memory_and_two_runs_give_the_same_bytes() {
    pass("shm", "demo");
}

#[test]
fn the_axis_in_cxx_passes_the_scenarios_of_the_axis() {
    pass("local", "demo-cpp");
}

#[test]
fn the_axis_in_rust_passes_the_scenarios_of_the_axis() {
    pass("local", "demo-rs");
}

#[test]
fn the_axis_in_python_passes_the_scenarios_of_the_axis() {
    pass("local", "demo-py");
}

#[test]
fn the_axis_in_lua_passes_the_scenarios_of_the_axis() {
    pass("local", "demo-lua");
}

#[test]
fn reports_are_the_same_on_local_and_on_shared_memory() {
    let place = Place::new();
    place.link("mission", "mission");
    let (file, lib) = (scenarios().join("links.toml"), place.path("lib"));
    let report = |backend: &str| {
        let told = place.test(&["--json", path(&file), "--path", path(&lib), "--backend", backend]);
        told.expect_code(0);
        serde_json::from_str::<Value>(&told.out).unwrap()
    };
    let local = report("local");
    assert_eq!(local["failed"], 0);
    assert_eq!(local, report("shm"));
}

#[test]
fn a_deployment_begins_a_scenario_and_its_clock_stands_still() {
    let place = Place::new();
    place.write(
        "robot.toml",
        "path = [\"lib\"]\nclock = \"monotonic\"\nbackend = \"shm\"\n[rpc]\nlisten = \"127.0.0.1:1\"\n\
         token_file = \"none\"\n[[component]]\nlibrary = \"demo\"\nname = \"axis\"\ndaemon = \"base\"\n\
         [component.attributes]\nset_speed = { velocity = 0.25 }\n\
         [[activity]]\ncomponent = \"axis\"\nservice = \"goto\"\ninputs = { goal = 0.5 }\n",
    );
    let text = "[[scenario]]\nname = \"a\"\ndeployment = \"robot.toml\"\nsteps = [\n\
                { call = \"axis/get_speed\", result = { velocity = 0.25 } },\n\
                { expect = \"axis/goto\", running = true },\n\
                { wait = \"axis/goto\", takes = \"2115ms\" },\n]\n";
    place.write("a.toml", text);
    place.test(&["a.toml"]).expect_code(0);
}

#[test]
fn components_are_loaded_and_connected_between_steps() {
    let place = Place::new();
    place.link("mission", "mission");
    let text = steps(
        "[\"demo\"]",
        &[
            "{ load = \"mission\" }",
            "{ connect = \"demo/parameter\", to = \"mission/gain\" }",
            // The axis reads the gain while it moves.
            "{ start = \"demo/goto\", inputs = { goal = 0.5 } }",
            "{ step = \"10ms\" }",
            "{ expect = \"demo/parameter\", value = 0.5, tolerance = 0.5 }",
            "{ disconnect = \"demo/parameter\" }",
            "{ unload = \"mission\" }",
            "{ expect = \"mission\", state = \"not loaded\" }",
        ],
    );
    place.write("a.toml", &text);
    place.test(&["a.toml"]).expect_code(0);
}

#[test]
fn what_is_interrupted_stops_and_leaves_nothing() {
    let place = Place::new();
    let long = "{ start = \"demo/goto\", inputs = { goal = 0.5 } }";
    place.write(
        "a.toml",
        &steps("[\"demo\"]", &[long, "{ step = \"3600s\" }", "{ step = \"3600s\" }"]),
    );
    let running = place.start(&["a.toml"]);
    until("a daemon runs", || !place.left().is_empty());
    running.signal("INT");
    running.finish().expect_code(1).expect_err("interrupted; what was started has ended");
    assert!(place.left().is_empty(), "{:?}", place.left());
}
