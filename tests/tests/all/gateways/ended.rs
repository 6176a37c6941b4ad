//! The process of a gateway ends, or stops: components go on, and what was open is open again.

use genom_tests::{Home, component, path, until};

use super::{NONE, Pair, gateway, ticks};

fn comes_back(pair: Pair) {
    pair.moves();
    pair.flows();
    let mut events = pair.near.events();
    pair.signal("KILL");
    events.wait_for(|event| event["event"] == "cell_runs" && event["cell"] == pair.gateway);
    // Ports in both directions, and a service that the peer calls.
    pair.flows();
    pair.near.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    until("the peer's mission drives the demo again", || {
        pair.far.ctl(&["call", "mission", "patrol", "rounds=1"]).code == Some(0)
    });
    let told = gateway(&pair.near, &pair.gateway);
    assert_eq!((told["state"].as_str(), told["starts"].as_u64()), (Some("running"), Some(2)));
    assert_eq!(told["last_end"], "signal 9 (SIGKILL)");
    let crashes = pair.near.ctl(&["crashes"]).out;
    assert!(crashes.contains(&pair.gateway), "{crashes}");
    // Nothing is left behind.
    let pid = told["pid"].to_string();
    let (_, home) = pair.near.stop("TERM");
    assert!(!std::path::Path::new(&format!("/proc/{pid}")).exists());
    let mut left = home.socket().into_os_string();
    left.push(".gateways");
    assert!(!std::path::Path::new(&left).exists());
}

#[test]
fn ports_and_services_on_zenoh_come_back_with_their_gateway() {
    comes_back(Pair::new("zenoh", "", &[]));
}

#[test]
fn ports_and_services_on_ros2_come_back_with_their_gateway() {
    comes_back(Pair::new("ros2", "", &[]));
}

#[test]
fn ports_and_services_on_ros2_over_zenoh_come_back_with_their_gateway() {
    comes_back(Pair::over_zenoh("", &[]));
}

#[test]
fn no_tick_waits_for_a_gateway_that_is_stopped() {
    let pair = Pair::new("zenoh", "[cells]\nalive_timeout = 600.0\n", &[]);
    pair.moves();
    pair.flows();
    pair.signal("STOP");
    let before = ticks(&pair.near);
    // More samples than all buffers on the way hold.
    until("ticks go on", || ticks(&pair.near) > before + 400);
    pair.signal("CONT");
    pair.flows();
    assert_eq!(gateway(&pair.near, &pair.gateway)["starts"], 1);
}

#[test]
fn a_gateway_that_stops_answering_is_started_again() {
    let pair = Pair::new("zenoh", "[cells]\nalive_timeout = 1.0\n", &[]);
    pair.moves();
    let mut events = pair.near.events();
    pair.signal("STOP");
    events.wait_for(|event| event["event"] == "cell_runs" && event["cell"] == pair.gateway);
    pair.flows();
}

#[test]
fn a_gateway_comes_back_soon_where_cells_wait_for_an_hour() {
    let an_hour = "[cells]\nrestart_delay = 3600.0\nrestart_delay_max = 3600.0\nrestart_most = 2\n";
    let pair = Pair::new("zenoh", an_hour, &[]);
    pair.moves();
    // More often than a cell would start again.
    for _ in 0..4 {
        let mut events = pair.near.events();
        pair.signal("KILL");
        events.wait_for(|event| event["event"] == "cell_runs" && event["cell"] == pair.gateway);
        pair.flows();
    }
    assert_eq!(gateway(&pair.near, &pair.gateway)["starts"], 5);
}

#[test]
fn why_a_middleware_cannot_be_opened_is_told_as_without_a_gateway() {
    let wrong = "[backends.zenoh]\nlisten = [\"tcp/192.0.2.1:1\"]\n";
    let told = |gateways: &str| {
        let home = Home::new();
        let config = format!("{gateways}{wrong}");
        std::fs::write(home.path().join("genomd.toml"), config).unwrap();
        let refused = home.refused(&["--backend", "zenoh"]);
        assert_eq!(refused.code, Some(3));
        let line = refused.err.lines().rfind(|line| line.starts_with("error: ")).map(str::to_owned);
        line.expect("an error")
    };
    let (with, without) = (told(""), told(NONE));
    assert!(with.starts_with("error: backend zenoh cannot be opened: "), "{with}");
    assert_eq!(with, without);
}

#[test]
fn a_name_of_a_gateway_is_no_name_of_a_cell() {
    let daemon = Home::new().start(&[]);
    let demo = component("demo").library;
    let refused = daemon.ctl(&["load", path(&demo), "--cell", "gateway-zenoh"]);
    assert!(refused.err.contains("`gateway-zenoh` is a name of a gateway"), "{}", refused.err);
    let refused = Home::new().configured("[gateways]\nof = [\"shm\"]\n").refused(&[]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.err.contains("shm has no gateway"), "{}", refused.err);
}
