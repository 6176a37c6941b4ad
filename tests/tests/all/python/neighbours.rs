//! Whatever a codel in Python does wrong, a component in C beside it runs each of its periods, and
//! publishes each of its samples.

use genom_tests::{Counts, Daemon, Home, component, path, until};
use serde_json::Value;
use tempfile::TempDir;

use super::{DESCRIPTION, axis, how, started_with};

/// What takes memory until there is none.
const TAKE: &str = "    if what == \"take\":
        held = []
        while True:
            held.append(bytearray(1 << 24))
";

/// A daemon on a stepped clock, in which the demo in C has begun to move.
fn moving(more: &[&str]) -> Daemon {
    let demo = component("demo");
    let options = ["--clock", "virtual", "--set", "cells.limits.memory=512"];
    let daemon = Home::new().start(&[&options[..], &[path(&demo.library)], more].concat());
    daemon.ctl(&["start", "demo", "goto", "goal=10"]).expect_code(0);
    daemon.step(20);
    daemon
}

/// What the demo has done, and where it is.
fn state_of(daemon: &Daemon) -> (Counts, Value) {
    let counts = daemon.counts("demo", "demo_servo", "position");
    (counts, daemon.port("demo", "position")["value"].clone())
}

/// The component does wrong what can be done wrong, while time is stepped; how often it was.
fn all_of_it(daemon: &Daemon) -> u64 {
    let mut steps = 0;
    let mut step = || {
        daemon.step(10);
        steps += 1;
    };
    let call = |what: &str| daemon.ctl(&["call", "axis", "how", &format!("what={what}")]);
    let start = |what: &str| {
        daemon.ctl(&["start", "axis", "run", &format!("what={what}")]).expect_code(0);
    };
    for (what, code) in [("divide", 1), ("sys.exit", 1), ("take", 1), ("fork", 0), ("print", 0)] {
        call(what).expect_code(code);
        step();
    }
    for what in ["keep", "type", "divide"] {
        start(what);
        step();
        step();
    }
    start("stop");
    step();
    daemon.ctl(&["abort", "axis", "run"]).expect_code(0);
    step();
    for what in ["exit", "crash"] {
        call(what).expect_code(1).expect_err("::genom::gone");
        // A step waits for no cell that is down, and is refused.
        until("the component is back", || call("no").code == Some(0));
        step();
    }
    steps
}

#[test]
fn a_component_in_c_runs_each_period_whatever_codels_in_python_do_beside_it() {
    let (_scratch, file) = axis(DESCRIPTION, &how(TAKE));
    let daemon = moving(&[path(&file)]);
    let steps = all_of_it(&daemon);
    let undisturbed = moving(&[]);
    undisturbed.step(10 * steps);
    let (counts, value) = state_of(&daemon);
    assert_eq!((counts, value), state_of(&undisturbed), "after {steps} steps");
    assert_eq!((counts.missed, counts.failed, counts.dropped), (0, 0, 0));
    assert_eq!(counts.written, counts.runs + 1, "each run, and the start codel, write one sample");
    let log = daemon.stop("TERM").0.err;
    for told in [
        "ZeroDivisionError",
        "SystemExit: 3",
        "MemoryError",
        "os.fork: the child ends",
        "more than 1 MiB is printed",
        "returned 4; it may return",
        "keeps a view of `at`",
        "it does not stop",
        "os._exit(3) ends this cell",
        "signal 11 (SIGSEGV)",
    ] {
        assert!(log.contains(told), "{told}: {log}");
    }
}

/// Counters of a motion of the demo to and fro, which takes as many periods each time.
fn motion(daemon: &Daemon) -> [u64; 2] {
    let before = daemon.counts("demo", "demo_servo", "position");
    for goal in ["goal=0.02", "goal=0"] {
        daemon.ctl(&["call", "demo", "goto", goal]).expect_code(0);
    }
    let after = daemon.counts("demo", "demo_servo", "position");
    assert_eq!((after.failed, after.dropped), (0, 0));
    [after.runs - before.runs, after.written - before.written]
}

/// A daemon with the demo, and the component with what more it does.
fn beside_the_demo(more: &str) -> (Daemon, TempDir) {
    let demo = component("demo");
    started_with(&how(more), &["--set", "stuck_after=1", path(&demo.library)])
}

#[test]
fn a_component_in_c_moves_on_while_a_codel_in_python_does_not_return() {
    let (daemon, _scratch) = beside_the_demo("");
    let alone = motion(&daemon);
    assert!(alone[0] > 10 && alone[0] == alone[1], "{alone:?}");
    daemon.ctl(&["start", "axis", "run", "what=block"]).expect_code(0);
    let told = daemon.process().error_line_where(|line| line.contains("time.sleep(3600)"));
    assert!(told.is_some());
    assert_eq!(motion(&daemon), alone);
    let running = daemon.json(&["activities", "axis"])["activities"][0]["status"].clone();
    assert_eq!(running, "running", "it does not return meanwhile");
}
