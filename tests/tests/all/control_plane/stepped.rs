//! `genomd --clock virtual`: time stands still until a supervisor steps it.

use genom_tests::{Daemon, path};

fn stepped() -> Daemon {
    let demo = genom_tests::component("demo");
    Daemon::start(&["--clock", "virtual", path(&demo.library)])
}

fn position(daemon: &Daemon) -> f64 {
    daemon.port("demo", "position")["value"]["position"].as_f64().expect("a position")
}

/// Positions after each of `steps` steps of a motion.
fn trajectory(step: &str, steps: usize) -> Vec<f64> {
    let daemon = stepped();
    daemon.ctl(&["start", "demo", "goto", "goal=0.5"]).expect_code(0);
    let walk = |_| {
        daemon.ctl(&["step", step]).expect_code(0);
        position(&daemon)
    };
    (0..steps).map(walk).collect()
}

#[test]
fn nothing_moves_until_the_clock_is_stepped() {
    let daemon = stepped();
    let started = daemon.ctl(&["start", "demo", "goto", "goal=1"]);
    started.expect_code(0);
    assert_eq!(position(&daemon), 0.0);
    daemon.ctl(&["step", "50ms"]).expect_code(0).expect_out("0.050000000 s\n");
    let after = position(&daemon);
    assert!(after > 0.0 && after < 1.0, "{after}");
    daemon.ctl(&["step", "10s"]).expect_code(0).expect_out("10.050000000 s\n");
    assert_eq!(position(&daemon), 1.0);
    daemon.ctl(&["wait", "demo", "2"]).expect_code(0).expect_out("done\n");
}

#[test]
fn the_same_inputs_give_the_same_motion_however_it_is_stepped() {
    let once = trajectory("20ms", 20);
    assert_eq!(once, trajectory("20ms", 20));
    let fine = trajectory("5ms", 80);
    let every_fourth: Vec<f64> = fine.into_iter().skip(3).step_by(4).collect();
    assert_eq!(once, every_fourth);
}

#[test]
fn only_a_virtual_clock_is_stepped() {
    let daemon = Daemon::demo("local");
    let refused = daemon.ctl(&["step", "10ms"]);
    refused.expect_code(1).expect_err("the machine's clock");
    refused.expect_err("genomd --clock virtual");
    stepped().ctl(&["step", "10"]).expect_code(2).expect_err("a unit is missing");
}
