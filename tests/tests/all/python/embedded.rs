//! A daemon that is a part of a program in Python, which steps it: `genom.Daemon`.

use std::path::Path;
use std::process::{Command, Stdio};

use genom_components::python;
use genom_tests::python_client::{client_tests, python as plain};
use genom_tests::{Running, WATCHDOG, component, fixture, path, program};

/// Runs tests of the client (`clients/python/tests`).
#[track_caller]
fn the_client_passes(tests: &str, interpreter: &Path, options: &[&str]) {
    let fixtures = tempfile::tempdir().unwrap();
    let _ = fixture("sights", "sights", fixtures.path());
    let _ = fixture("texts", "texts", fixtures.path());
    let [demo, mission, blocks] = ["demo", "mission", "blocks"].map(component);
    let mut command = client_tests(interpreter, options, tests);
    command
        .env("TMPDIR", fixtures.path())
        .env("XDG_STATE_HOME", fixtures.path().join("state"))
        .env("JUPYTER_RUNTIME_DIR", fixtures.path().join("jupyter"))
        .env("IPYTHONDIR", fixtures.path().join("ipython"))
        .env("GENOMD", program("genomd"))
        .env("GENOM_DEMO", path(&demo.library))
        .env("GENOM_MISSION", path(&mission.library))
        .env("GENOM_BLOCKS", path(&blocks.library))
        .env("GENOM_FIXTURES", fixtures.path());
    // Each test in Python has a watchdog of its own.
    let finished = Running::start(&mut command).finish_within(5 * WATCHDOG);
    finished.expect_client_passed();
}

/// `-S`: without installed packages, so that only the standard library is available.
#[test]
fn a_program_steps_its_daemon_with_the_standard_library_alone() {
    the_client_passes("tests.test_embedded", &plain(), &["-S"]);
}

/// How a step goes without a message, with a daemon that is part of the test.
#[test]
fn a_program_steps_its_daemon_in_memory_that_both_have() {
    the_client_passes("tests.test_slate", &plain(), &["-S"]);
}

#[test]
fn a_program_shares_ports_of_components_in_cells() {
    the_client_passes("tests.test_embedded_cells", &plain(), &["-S"]);
}

#[test]
fn five_hundred_ports_of_an_embedded_daemon_take_a_file_each_and_give_it_back() {
    the_client_passes("tests.test_embedded_files", &plain(), &["-S"]);
}

#[test]
fn a_program_steps_its_daemon_and_has_ports_as_numpy_arrays() {
    let python = python::environment(&["numpy==2.4.6"]).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes("tests.test_embedded", &python, &[]);
    the_client_passes("tests.test_embedded_numpy", &python, &[]);
}

/// Jupyter warns of what is its own, so that warnings are no errors here.
#[test]
fn a_notebook_steps_its_daemon() {
    let python =
        python::environment(&["ipykernel==6.30.1"]).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes("tests.test_notebook", &python, &["-W", "ignore"]);
}

#[test]
fn only_a_program_with_the_other_end_of_a_socket_embeds_a_daemon() {
    let scratch = tempfile::tempdir().unwrap();
    let mut command = Command::new(program("genomd"));
    command.arg("--embedded").arg("--socket").arg(scratch.path().join("genomd.sock"));
    command.stdin(Stdio::null());
    let refused = Running::start(&mut command).finish();
    refused.expect_code(2).expect_err("one end of a pair of sockets").expect_err("genom.Daemon");
}
