//! Codels in Python that end their process: others go on, and it is told which line did it.

use genom_tests::{Daemon, Home, component, path, until};
use tempfile::TempDir;

use super::{DESCRIPTION, SCRIPT, axis, started};

/// A daemon with the component, and the demo in C in its own process.
fn beside_the_demo() -> (Daemon, TempDir) {
    let demo = component("demo");
    started(&[path(&demo.library)])
}

/// Ends the process by one call; the demo does not notice, and the component comes back.
#[track_caller]
fn ends(what: &str, end: &str) -> String {
    let (daemon, _scratch) = beside_the_demo();
    let called = daemon.ctl(&["call", "axis", "how", &format!("what={what}")]);
    called.expect_code(1).expect_err("::genom::gone").expect_err(end);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    until("the component is back", || {
        daemon.ctl(&["call", "axis", "how", "what=no"]).out == "tries = 1\n"
    });
    until("the end is reported", || {
        let reports = daemon.json(&["crashes"]);
        reports["crashes"].as_array().is_some_and(|all| all.len() == 1)
    });
    let listed = daemon.ctl(&["crashes"]).out;
    assert!(listed.contains("axis_how"), "{listed}");
    daemon.stop("TERM").0.err
}

#[test]
fn os_exit_is_told_with_its_line() {
    let log = ends("exit", "exit status 3");
    assert!(log.contains("os._exit(3) ends this cell"), "{log}");
    assert!(log.contains("axis.py\", line 20, in axis_how"), "{log}");
}

#[test]
fn a_crash_of_native_code_is_told_with_the_line_that_called_it() {
    let log = ends("crash", "signal 11 (SIGSEGV)");
    assert!(log.contains("axis.py\", line 24 in axis_how"), "{log}");
}

#[test]
fn a_child_that_a_codel_forked_ends_and_the_codel_goes_on() {
    let (daemon, _scratch) = started(&[]);
    daemon.ctl(&["call", "axis", "how", "what=fork"]).expect_code(0).expect_out("tries = 1\n");
    daemon.ctl(&["call", "axis", "how", "what=fork"]).expect_code(0).expect_out("tries = 2\n");
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 3\n");
    let (finished, _) = daemon.stop("TERM");
    finished.expect_err("axis.py\", line 27, in axis_how");
    assert_eq!(finished.err.matches("os.fork: the child ends").count(), 1, "{}", finished.err);
}

#[test]
fn a_codel_that_takes_memory_without_end_is_told_with_its_line_and_goes_on() {
    let takes = "    if what == \"take\":\n        take([])\n    if what == \"print\":";
    let script = SCRIPT.replace("    if what == \"print\":", takes)
        + "\n\ndef take(held):\n    while True:\n        held.append(bytearray(1 << 24))\n";
    let line = 1 + script.lines().position(|line| line.contains("held.append")).unwrap();
    let (_scratch, file) = axis(DESCRIPTION, &script);
    let demo = component("demo");
    let limit = ["--set", "cells.limits.memory=1024"];
    let daemon = Home::new().start(&[&limit[..], &[path(&demo.library), path(&file)]].concat());
    let called = daemon.ctl(&["call", "axis", "how", "what=take"]);
    called.expect_code(1).expect_err("::genom::unkex").expect_err("MemoryError");
    daemon.ctl(&["call", "axis", "how", "what=no"]).expect_code(0).expect_out("tries = 2\n");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let log = daemon.stop("TERM").0.err;
    assert!(log.contains(&format!("axis.py\", line {line}, in take")), "{log}");
}
