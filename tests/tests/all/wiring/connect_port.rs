//! Service `connect_port` of components on a network.

use std::time::{Duration, Instant};

use genom_tests::{Daemon, Running};

/// How long a newcomer on a network may take to become visible.
const NETWORK: Duration = Duration::from_secs(2);

#[test]
fn what_is_not_there_is_told_at_once_and_holds_up_nothing_that_is_asked_after_it() {
    let daemon = Daemon::demo("zenoh");
    let inputs = r#"{"local":"parameter","remote":"nobody/gain"}"#;
    let ask = || daemon.spawn(&["call", "demo", "connect_port", inputs]);
    let told = |asked: Running| {
        asked.finish().expect_code(1).expect_err("::genom::no_such_outport");
    };
    // The daemon itself is new on the network, and may look for as long as others take to show.
    told(ask());
    let begin = Instant::now();
    let asked: Vec<Running> = (0..20).map(|_| ask()).collect();
    asked.into_iter().for_each(told);
    // One after the other; each of them had waited for a newcomer.
    assert!(begin.elapsed() < NETWORK * 10, "{:?}", begin.elapsed());
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.stop("TERM").0.expect_code(0);
}
