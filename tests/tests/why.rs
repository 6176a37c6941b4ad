//! `genomctl why`: each reason why no data flows is told with its fix.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use genom_tests::{Daemon, component, path};

#[test]
fn every_reason_is_told_and_goes_when_it_is_removed() {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library)]);
    let why = |port: &str| {
        let told = daemon.ctl(&["why", port]);
        told.expect_code(0);
        // Ticks missed on a busy machine are told too.
        let lines = told.out.lines().map(str::to_owned);
        lines.take_while(|line| !line.starts_with("task ")).collect::<Vec<_>>().join("\n")
    };
    assert!(why("demo/parameter").starts_with("demo/parameter is not connected"));
    daemon.ctl(&["connect", "--wait", "demo/parameter", "paper/position"]).expect_code(0);
    assert!(why("demo/parameter").starts_with("nobody publishes paper/position on shm"));
    daemon.ctl(&["load", path(&paper.description), "--name", "paper"]).expect_code(0);
    let never = "paper/position was never written, and no activity runs";
    assert!(why("paper/position").starts_with(never), "{}", why("paper/position"));
    assert!(why("demo/parameter").starts_with("demo/parameter read nothing from paper/position"));
    daemon.ctl(&["call", "paper", "goto", "position=0.25"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    for port in ["demo/parameter", "demo/position"] {
        let told = why(port);
        assert!(told.is_empty() || told == "data flows: nothing is wrong", "{told}");
    }
    daemon.ctl(&["why", "demo/positon"]).expect_code(1).expect_err("did you mean `position`?");
}
