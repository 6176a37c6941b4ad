//! Components of a cell that may not use the network reach it through a gateway, and nothing else.

use std::net::UdpSocket;

use genom_tests::{component, path, until};
use serde_json::json;

use super::Pair;

const LIMITS: &str = "[cell.demo]\nnetwork = false\n[cell.trespasses]\nnetwork = false\n";

fn speaks(pair: Pair) {
    pair.moves();
    pair.flows();
    pair.near.ctl(&["call", "demo", "set_speed", "velocity=2"]).expect_code(0);
    until("the peer's mission drives the demo", || {
        pair.far.ctl(&["call", "mission", "patrol", "rounds=1"]).code == Some(0)
    });
    // It reaches the next gateway, too.
    let mut events = pair.near.events();
    pair.signal("KILL");
    events.wait_for(|event| event["event"] == "cell_runs" && event["cell"] == pair.gateway);
    pair.moves();
    pair.flows();
    let cells = pair.near.json(&["cells"]);
    let all = cells["cells"].as_array().unwrap();
    let demo = all.iter().find(|cell| cell["name"] == "demo").unwrap();
    assert_eq!((&demo["starts"], &demo["components"]), (&json!(1), &json!(["demo"])));
    // Its neighbour under the same limits does not reach the network by itself.
    let library = component("trespasses").library;
    pair.near.ctl(&["load", path(&library), "--isolated"]).expect_code(0);
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = format!("port={}", udp.local_addr().unwrap().port());
    let tried = pair.near.json(&["call", "trespasses", "send_udp", &port]);
    assert_eq!(tried["result"]["error"], 13, "EACCES");
}

#[test]
fn a_component_without_network_rights_speaks_ros_2_through_its_gateway() {
    speaks(Pair::new("ros2", LIMITS, &["--isolated"]));
}

#[test]
fn a_component_without_network_rights_speaks_zenoh_through_its_gateway() {
    speaks(Pair::new("zenoh", LIMITS, &["--isolated"]));
}

#[test]
fn a_component_without_network_rights_speaks_ros_2_over_zenoh_through_its_gateway() {
    speaks(Pair::over_zenoh(LIMITS, &["--isolated"]));
}
