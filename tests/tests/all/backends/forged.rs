//! Forged datagrams that would end a whole daemon, sent to one in which a component runs.

use std::net::UdpSocket;

use crate::forger::{Forger, USER, announcement_ports, fragment, gap, heartbeat, ports};
use genom_tests::{Daemon, Footprint, Home, component, path, until};

/// Number of ticks of the demo's task.
fn ticks(daemon: &Daemon) -> u64 {
    let told = daemon.json(&["stats", "demo"]);
    let tasks = told["tasks"].as_array().unwrap();
    tasks.iter().map(|task| task["cycles"]["count"].as_u64().unwrap()).sum()
}

#[test]
fn a_component_goes_on_under_datagrams_that_would_end_its_daemon() {
    goes_on("[gateways]\nof = []\n");
}

#[test]
fn a_component_goes_on_under_datagrams_that_would_end_its_gateway() {
    goes_on("");
}

fn goes_on(gateways: &str) {
    let home = Home::new().configured(gateways);
    let domain = u16::try_from(home.memory().domain()).unwrap();
    let namespace = home.memory().prefix().trim_end_matches('_').to_owned();
    let demo = component("demo");
    let daemon = home.start(&["--backend", "ros2", path(&demo.library)]);
    let topic = format!("rt/{namespace}/demo/parameter");
    let socket = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
    let port = socket.local_addr().unwrap().port();
    let forger = Forger(*b"\x01\x10forged....");
    let cells = daemon.json(&["cells"]);
    let gateway = cells["cells"][0]["pid"].as_u64().map(|pid| u32::try_from(pid).unwrap());
    assert_eq!(gateway.is_some(), gateways.is_empty());
    let victim = gateway.unwrap_or(daemon.process().id());
    let before = Footprint::of(victim).peak;
    // First it announces itself, with a writer of what the demo reads.
    let announced = || {
        for to in announcement_ports(domain) {
            let _ = socket.send_to(&forger.announcement(1, port, 100), ("127.0.0.1", to));
            let _ = socket.send_to(
                &forger.writer(&topic, "std_msgs::msg::dds_::Float64_"),
                ("127.0.0.1", to),
            );
        }
    };
    let hostile = [
        heartbeat(USER, 1, 1 << 31, 9),
        heartbeat(USER, 1, 1 << 62, 10),
        fragment(USER, 1, (1, 1, u16::MAX), u32::MAX, &[0; 1000]),
        gap(USER, 2, 1 << 40),
    ];
    until("the hostile datagrams are refused", || {
        announced();
        for datagram in hostile.iter().map(|one| forger.message(std::slice::from_ref(one))) {
            for to in ports(domain) {
                let _ = socket.send_to(&datagram, ("127.0.0.1", to));
            }
        }
        let told = daemon.ctl(&["doctor"]).out;
        told.contains("more sequence numbers than a writer can hold")
            && told.contains("a sample above [backends.ros2] greatest_sample")
            && told.contains("127.0.0.1")
    });
    let then = ticks(&daemon);
    until("the task goes on", || ticks(&daemon) > then + 5);
    let grown = Footprint::of(victim).peak.saturating_sub(before) >> 10;
    assert!(grown < 64, "{grown} MiB more");
}
