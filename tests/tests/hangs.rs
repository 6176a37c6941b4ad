//! Codels that do not return: what must still work meanwhile, and how the daemon ends.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use genom_tests::{Daemon, component, path};

fn hanging() -> Daemon {
    let blocks = component("blocks");
    let daemon = Daemon::demo("local");
    daemon.ctl(&["load", path(&blocks.library)]).expect_code(0);
    let mut events = daemon.events();
    daemon.ctl(&["start", "blocks", "hang"]).expect_code(0);
    events.wait_for(|e| e["event"] == "activity_started" && e["service"] == "hang");
    daemon
}

#[test]
fn a_codel_that_hangs_holds_up_nobody_else() {
    let daemon = hanging();
    daemon.ctl(&["call", "blocks", "get_count"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
}

#[test]
fn a_second_signal_ends_a_daemon_whose_codels_hang() {
    let daemon = hanging();
    let mut events = daemon.events();
    daemon.process().signal("TERM");
    events.wait_for(|e| e["event"] == "stopping");
    let (stopped, home) = daemon.stop("TERM");
    stopped.expect_code(1).expect_err("before all codels had ended");
    assert!(!home.socket().exists());
}
