//! The daemon ends without having stopped its gateways.

use std::path::PathBuf;

use genom_tests::{Home, component, path, until};

use super::{Pair, gateway};

/// The program of a process, as long as it lives.
fn program(pid: &str) -> PathBuf {
    PathBuf::from(format!("/proc/{pid}/exe"))
}

#[test]
fn cells_reach_the_network_without_their_daemon_and_the_next_one_takes_the_gateway_over() {
    let pair = Pair::new("zenoh", "", &["--isolated"]);
    pair.moves();
    let pid = gateway(&pair.near, &pair.gateway)["pid"].to_string();
    let Pair { near, far, gateway: name } = pair;
    let home = near.abandon();
    let seen = || far.port("mission", "position")["value"].clone();
    let before = seen();
    until("the peer gets new positions", || seen() != before);
    let near = home.start(&["--backend", "zenoh"]);
    assert_eq!(gateway(&near, &name)["pid"].to_string(), pid);
    let pair = Pair { near, far, gateway: name };
    pair.flows();
    // It comes back as one that this daemon started itself.
    let mut events = pair.near.events();
    pair.signal("KILL");
    events.wait_for(|event| event["event"] == "cell_runs" && event["cell"] == pair.gateway);
    pair.flows();
}

#[test]
fn a_gateway_ends_when_the_only_process_that_used_it_was_killed() {
    let demo = component("demo").library;
    let home = Home::new();
    let daemon = home.start(&["--backend", "zenoh", path(&demo)]);
    let pid = gateway(&daemon, "gateway-zenoh")["pid"].to_string();
    let home = daemon.abandon();
    until("it ends", || !program(&pid).exists());
    // The next daemon starts its own.
    let daemon = home.start(&["--backend", "zenoh", path(&demo)]);
    assert_ne!(gateway(&daemon, "gateway-zenoh")["pid"].to_string(), pid);
}
