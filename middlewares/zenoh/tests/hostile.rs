//! Peers that send invalid data, and sessions that are killed.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

mod world;

use std::io::Read as _;

use genom_conformance::samples::{note, note_of, numbered, state};
use genom_conformance::{World, eventually};
use genom_middleware::{Address, Discovery, EndpointKind, Policy, PortSpec, Ports, Reading};
use genom_types::{DataType, Record};
use genom_zenoh::{Options, Zenoh};
use world::Meeting;
use zenoh::Wait;

fn position() -> Address {
    Address::new("demo", "position")
}

/// A session of plain zenoh, connected to one of ours.
fn plain(place: &Meeting) -> zenoh::Session {
    let socket = place.leftovers().into_iter().find(|path| path.ends_with(".sock")).unwrap();
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("connect/endpoints", format!("[\"unixsock-stream/{socket}\"]")),
        ("listen/endpoints", "[]".to_owned()),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// A deterministic pseudo-random number generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Returns the message with some bytes changed, and often truncated.
    fn spoil(&mut self, message: &[u8]) -> Vec<u8> {
        let mut bad = message.to_vec();
        for _ in 0..self.next() % 4 {
            let at = self.next() as usize % bad.len();
            bad[at] = self.next() as u8;
        }
        if self.next().is_multiple_of(2) {
            bad.truncate(self.next() as usize % bad.len());
        }
        bad
    }
}

/// Sends 2,000 corrupted messages and checks that each is either read or refused and counted.
fn suffers(ty: &DataType, value: &Record) {
    let place = Meeting::new();
    let ours = place.open();
    let mut reader = ours.subscription(&PortSpec::new(&position(), ty), Policy::Queue(4)).unwrap();
    let peer = plain(&place);
    let publisher = peer.declare_publisher("demo/position").wait().unwrap();
    eventually("the reader is seen", || publisher.matching_status().wait().unwrap().matching());
    let mut message = Vec::new();
    value.encode_message(&mut message).unwrap();
    let (mut noise, mut refused, mut got) = (Noise(0x9e37_79b9_7f4a_7c15), 0, Record::new(ty));
    for _ in 0..2000 {
        publisher.put(noise.spoil(&message)).wait().unwrap();
        eventually("it is read or refused", || match reader.read(&mut got) {
            Ok(reading) => reading == Reading::New,
            Err(_) => {
                refused += 1;
                true
            }
        });
    }
    assert!(refused > 500, "most of it is nonsense: {refused}");
    assert_eq!(reader.dropped(), refused);
    publisher.put(message).wait().unwrap();
    eventually("a good one is read", || reader.read(&mut got) == Ok(Reading::New));
    assert_eq!(got.to_json(), value.to_json());
}

#[test]
fn nonsense_of_a_fixed_type_is_refused_and_counted() {
    suffers(&state(), &numbered(7));
}

#[test]
fn nonsense_of_a_variable_type_is_refused_and_counted() {
    let mut value = Record::new(&note());
    value.merge_json(&note_of(6)).unwrap();
    suffers(&note(), &value);
}

#[test]
fn the_first_session_may_end_and_the_others_stay_together() {
    let place = Meeting::new();
    let (first, a, b) = (place.open(), place.open(), place.open());
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    drop(first);
    let late = place.open();
    let mut got = Record::new(&state());
    for session in [&b, &late] {
        let mut reader =
            session.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
        writer.publish(&numbered(3)).unwrap();
        eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    }
}

/// Environment variable with the rendezvous folder of the process that is killed.
const PLACE: &str = "GENOM_ZENOH_WRITER_PLACE";

#[test]
#[ignore = "is another process, which the next test starts"]
fn writes_until_it_is_killed() {
    let Some(place) = std::env::var_os(PLACE) else { return };
    let options = Options { rendezvous: Some(place.into()), ..Options::default() };
    let zenoh = Zenoh::open(&options).unwrap();
    let mut writer = zenoh.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(9)).unwrap();
    // Ends with the test if it is not killed before.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

#[test]
fn a_killed_peer_is_forgotten_and_leaves_no_socket() {
    let place = Meeting::new();
    let ours = place.open();
    let mut victim = genom_conformance::again("writes_until_it_is_killed")
        .env(PLACE, place.options().rendezvous.unwrap())
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut reader =
        ours.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    let mut got = Record::new(&state());
    eventually("its value arrives", || reader.read(&mut got).unwrap() == Reading::New);
    victim.kill().unwrap();
    victim.wait().unwrap();
    eventually("its port is gone", || {
        let seen = ours.discover().unwrap();
        !seen.iter().any(|end| end.kind == EndpointKind::Publisher)
    });
    let mut writer = ours.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(10)).unwrap();
    eventually("another one takes its place", || reader.read(&mut got).unwrap() == Reading::New);
    drop((writer, reader));
    // The next session cleans up, and leaves nothing behind itself.
    drop(place.open());
    drop(ours);
    eventually("nothing is left", || place.leftovers().is_empty());
}
