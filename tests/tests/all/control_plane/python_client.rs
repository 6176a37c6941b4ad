//! Runs the Python client's own tests (clients/python/tests), each file against a daemon of its
//! own.

use std::path::Path;
use std::process::Command;

use genom_components::python;
use genom_tests::python_client::{client_tests, python as plain};
use genom_tests::{Daemon, Finished, Running, component, fixture, path, program, repository};

/// Runs one file of the client's tests; provides external components to those that need them.
#[track_caller]
fn the_client_passes(interpreter: &Path, options: &[&str], file: &str, backend: &str) -> Finished {
    the_client_passes_with(interpreter, options, file, &["--backend", backend])
}

#[track_caller]
fn the_client_passes_with(
    interpreter: &Path,
    options: &[&str],
    file: &str,
    daemon: &[&str],
) -> Finished {
    let fixtures = tempfile::tempdir().expect("a directory can be made");
    if ["tests.test_images", "tests.test_names"].contains(&file) {
        let _ = fixture("others", "viewer", fixtures.path());
    }
    let demo = component("demo");
    let daemon = Daemon::start(daemon);
    let mut command = client_tests(interpreter, options, file);
    command
        .env("GENOMD_SOCKET", daemon.home().socket())
        .env("GENOM_DEMO", path(&demo.library))
        .env("GENOM_FIXTURES", fixtures.path())
        .env("GENOMCTL", program("genomctl"));
    let finished = Running::start(&mut command).finish();
    finished.expect_client_passed();
    finished
}

/// `-S`: without installed packages, so that only the standard library is available.
#[track_caller]
fn the_standard_library_is_enough(file: &str, backend: &str) {
    the_client_passes(&plain(), &["-S"], file, backend);
}

#[test]
fn scripts_for_the_fields_python_client_find_their_names() {
    the_standard_library_is_enough("tests.test_names", "local");
}

#[test]
fn python_steps_time() {
    the_client_passes_with(&plain(), &["-S"], "tests.test_stepped", &["--clock", "virtual"]);
}

#[test]
fn python_calls_services_and_follows_activities_and_events() {
    the_standard_library_is_enough("tests.test_control", "local");
}

#[test]
fn python_proves_tokens_as_genomctl_does() {
    the_standard_library_is_enough("tests.test_proof", "local");
}

#[test]
fn python_asks_and_reads_what_the_document_tells() {
    the_standard_library_is_enough("tests.test_document", "local");
}

#[test]
fn python_reads_and_feeds_ports_through_the_daemon() {
    the_standard_library_is_enough("tests.test_ports", "local");
}

#[test]
fn python_is_told_when_the_daemon_goes_away() {
    the_standard_library_is_enough("tests.test_gone", "local");
}

#[test]
fn python_is_told_when_the_daemon_stands_still() {
    the_standard_library_is_enough("tests.test_stopped", "local");
}

/// Prints the figures that the tests measured: `count` lines.
#[track_caller]
#[allow(clippy::print_stdout, reason = "figures are for whoever runs the test")]
fn figures(finished: &Finished, count: usize) {
    let told = ["round trips", "1 kHz", "two images"];
    let figure = |line: &&str| told.iter().any(|told| line.contains(told));
    let found: Vec<_> = finished.err.lines().filter(figure).collect();
    assert_eq!(found.len(), count, "{}", finished.err);
    found.iter().for_each(|figure| println!("{figure}"));
}

#[test]
fn python_shares_the_memory_of_ports() {
    let python =
        python::environment(&["iceoryx2==0.10.0"]).unwrap_or_else(|error| panic!("{error}"));
    figures(&the_client_passes(&python, &[], "tests.test_shared_memory", "shm"), 3);
}

#[test]
fn python_speaks_zenoh_with_ports() {
    let python =
        python::environment(&["eclipse-zenoh==1.10.2"]).unwrap_or_else(|error| panic!("{error}"));
    figures(&the_client_passes(&python, &[], "tests.test_zenoh", "zenoh"), 2);
}

/// Both packages, for ports that move from one middleware to another.
const STRAIGHT: [&str; 2] = ["iceoryx2==0.10.0", "eclipse-zenoh==1.10.2"];

#[test]
fn python_goes_where_ports_go() {
    let python = python::environment(&STRAIGHT).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes(&python, &[], "tests.test_moves", "shm");
}

#[test]
fn python_passes_images_the_same_on_every_way() {
    let python = python::environment(&STRAIGHT).unwrap_or_else(|error| panic!("{error}"));
    figures(&the_client_passes(&python, &[], "tests.test_images", "shm"), 1);
}

#[test]
fn codels_in_python_need_only_the_standard_library() {
    the_standard_library_is_enough("tests.test_codels", "local");
}

#[test]
fn codels_in_python_use_numpy_where_it_is() {
    let python = python::environment(&["numpy==2.4.6"]).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes(&python, &[], "tests.test_codels", "local");
    the_client_passes(&python, &[], "tests.test_numpy", "local");
}

#[test]
fn what_codels_print_is_counted() {
    the_standard_library_is_enough("tests.test_odd", "local");
}

#[test]
fn views_that_codels_keep_are_told() {
    the_standard_library_is_enough("tests.test_kept", "local");
    let python = python::environment(&["numpy==2.4.6"]).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes(&python, &[], "tests.test_kept", "local");
}

#[test]
fn type_checkers_know_components_by_their_stubs() {
    let python = python::environment(&["mypy==2.4.1"]).unwrap_or_else(|error| panic!("{error}"));
    the_client_passes(&python, &[], "tests.test_stubs", "local");
}

#[test]
fn the_python_client_is_typed() {
    let python = python::environment(&["mypy==2.4.1"]).unwrap_or_else(|error| panic!("{error}"));
    let scratch = tempfile::tempdir().expect("a directory can be made");
    let mut command = Command::new(python);
    command.current_dir(repository().join("clients/python"));
    command.args(["-m", "mypy", "--cache-dir"]).arg(scratch.path());
    let finished = Running::start(&mut command).finish();
    assert_eq!(finished.code, Some(0), "{}", finished.out);
}
