//! Sessions of one machine reach each other through shared memory, without using a network.

#![allow(clippy::unwrap_used, reason = "test code that stands outside of test functions")]

mod world;

use std::collections::HashSet;
use std::fs;
use std::net::UdpSocket;
use std::sync::{Arc, Mutex};

use genom_conformance::samples::{image, numbered, state};
use genom_conformance::{World, eventually};
use genom_middleware::{Address, Discovery, PortSpec, Ports};
use genom_types::Record;
use world::Meeting;
use zenoh::{Session, Wait};

/// A session of plain zenoh, connected to the daemon with this rendezvous folder.
fn program(place: &Meeting) -> Session {
    let socket = place.leftovers().into_iter().find(|path| path.ends_with(".sock")).unwrap();
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("connect/endpoints", format!("[\"unixsock-stream/{socket}\"]").as_str()),
        ("listen/endpoints", "[]"),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
    ] {
        config.insert_json5(key, value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

#[test]
fn large_samples_travel_in_shared_memory_and_small_ones_do_not() {
    let place = Meeting::new();
    let zenoh = place.open();
    let program = program(&place);
    let arrived: Arc<Mutex<Vec<(usize, bool)>>> = Arc::default();
    let seen = Arc::clone(&arrived);
    let see = move |sample: zenoh::sample::Sample| {
        let payload = sample.payload();
        seen.lock().unwrap().push((payload.len(), payload.as_shm().is_some()));
    };
    let _subscriber = program.declare_subscriber("demo/*").callback(see).wait().unwrap();
    let mut camera =
        zenoh.publisher(&PortSpec::new(&Address::new("demo", "camera"), &image())).unwrap();
    let mut pose =
        zenoh.publisher(&PortSpec::new(&Address::new("demo", "pose"), &state())).unwrap();
    let picture = Record::new(&image());
    let came = |large: bool, shared: bool| {
        let arrived = arrived.lock().unwrap();
        arrived.iter().any(|(size, memory)| (*size > 4096) == large && *memory == shared)
    };
    // zenoh allocates its shared memory on first use, so the first samples may be sent without it.
    eventually("a large sample comes in shared memory", || {
        camera.publish(&picture).unwrap();
        pose.publish(&numbered(1)).unwrap();
        came(true, true) && came(false, false)
    });
    assert!(!came(false, true), "64 bytes need no shared memory");
}

/// Number of TCP and UDP sockets of this process.
fn network_sockets() -> usize {
    let links = fs::read_dir("/proc/self/fd").unwrap().filter_map(|fd| {
        // Some are closed meanwhile.
        let link = fs::read_link(fd.ok()?.path()).ok()?;
        Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned())
    });
    let own: HashSet<String> = links.collect();
    let tables = ["tcp", "tcp6", "udp", "udp6"].map(|table| {
        // A system without IPv6 has no such table.
        fs::read_to_string(format!("/proc/self/net/{table}")).unwrap_or_default()
    });
    let inodes = tables.iter().flat_map(|table| table.lines().skip(1));
    inodes.filter_map(|line| line.split_whitespace().nth(9)).filter(|i| own.contains(*i)).count()
}

#[test]
fn sessions_of_one_machine_meet_without_any_network() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let _writer = a.publisher(&PortSpec::new(&Address::new("demo", "far"), &state())).unwrap();
    eventually("they see each other", || {
        b.discover().unwrap().iter().any(|end| end.address == "demo/far")
    });
    assert_eq!(network_sockets(), 0);
    // Checks that the count would notice a socket.
    let _socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    assert_eq!(network_sockets(), 1);
}
