//! Services `connect_port` and `connect_service` of components on a network.

use std::time::{Duration, Instant};

use genom_tests::{Daemon, Running, fixture};

/// How long a new participant on a network may take to become visible.
const NETWORK: Duration = Duration::from_secs(2);

#[test]
fn ports_that_are_not_there_are_told_at_once_and_hold_up_nothing_that_is_asked_after_them() {
    let daemon = Daemon::demo("zenoh");
    let inputs = r#"{"local":"parameter","remote":"nobody/gain"}"#;
    told_at_once(&daemon, &["call", "demo", "connect_port", inputs], "::genom::no_such_outport");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn services_that_are_not_there_are_told_at_once_as_well() {
    let files = tempfile::tempdir().unwrap();
    let caller = fixture("adders", "caller", files.path());
    let daemon = Daemon::start(&["--backend", "zenoh", &caller]);
    let inputs = r#"{"local":"add","remote":"nobody/add"}"#;
    let call = ["call", "caller", "connect_service", inputs];
    told_at_once(&daemon, &call, "::genom::no_such_service");
    daemon.stop("TERM").0.expect_code(0);
}

/// Calls many times; each call must be refused without waiting for new participants.
#[track_caller]
fn told_at_once(daemon: &Daemon, call: &[&str], exception: &str) {
    let ask = || daemon.spawn(call);
    let told = |asked: Running| {
        asked.finish().expect_code(1).expect_err(exception);
    };
    // The daemon itself is new on the network, and may wait as long as others take to become
    // visible.
    told(ask());
    let begin = Instant::now();
    let asked: Vec<Running> = (0..20).map(|_| ask()).collect();
    asked.into_iter().for_each(told);
    // In sequence; if each had waited for a new participant, they would take longer.
    assert!(begin.elapsed() < NETWORK * 10, "{:?}", begin.elapsed());
}
