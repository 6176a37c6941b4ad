//! Programs that use only iceoryx2 read and write ports by the name and layout of their type.

mod world;

use genom_conformance::eventually;
use genom_conformance::samples::{basic, note, number, numbered, state};
use genom_middleware::{Address, OpenError, Policy, PortSpec, Ports, ReadError, Reading};
use genom_types::{Kind, Record};
use serde_json::json;

use world::ShmWorld;
use world::process::Process;

const PEER: &str = env!("CARGO_BIN_EXE_shm-typed-peer");

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn a_typed_peer_reads_an_out_port_and_its_last_value() {
    let world = ShmWorld::new();
    let shm = world.open();
    let mut writer = shm.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(41)).unwrap();
    let mut peer = Process::start(PEER, &world, &["read", "demo/position"]);
    assert_eq!(peer.says(), "ready");
    peer.tell("");
    // Gets the last value, although the writer has written nothing since.
    assert_eq!(peer.says(), "41 [41.0, 42.0, 43.0, 44.0, 45.0, 46.0, 47.0]");
    for n in 42..60 {
        writer.publish(&numbered(n)).unwrap();
        peer.tell("");
        assert!(peer.says().starts_with(&format!("{n} [")));
    }
    peer.end();
}

#[test]
fn a_port_of_a_basic_type_has_the_name_rust_gives_it() {
    let world = ShmWorld::new();
    let shm = world.open();
    let ty = basic(Kind::Double);
    let mut writer = shm.publisher(&PortSpec::new(&position(), &ty)).unwrap();
    let mut value = Record::new(&ty);
    value.merge_json(&json!(-0.25)).unwrap();
    writer.publish(&value).unwrap();
    let mut peer = Process::start(PEER, &world, &["read-double", "demo/position"]);
    assert_eq!(peer.says(), "ready");
    peer.tell("");
    assert_eq!(peer.says(), "-0.25");
    peer.end();
}

#[test]
fn a_typed_peer_writes_an_in_port_of_any_policy() {
    let world = ShmWorld::new();
    let shm = world.open();
    let policies = [Policy::Latest, Policy::Ring(4), Policy::Queue(4)];
    let mut readers = policies
        .map(|policy| shm.subscription(&PortSpec::new(&position(), &state()), policy).unwrap());
    let mut peer = Process::start(PEER, &world, &["write", "demo/position"]);
    assert_eq!(peer.says(), "ready");
    let mut got = Record::new(&state());
    for n in 1..20 {
        peer.tell(&n.to_string());
        assert_eq!(peer.says(), "sent");
        for reader in &mut readers {
            eventually("the sample arrives", || reader.read(&mut got) == Ok(Reading::New));
            assert_eq!(number(&got), n);
        }
    }
    peer.end();
}

#[test]
fn a_port_that_a_peer_made_first_can_be_read() {
    let world = ShmWorld::new();
    let mut peer = Process::start(PEER, &world, &["create", "demo/position"]);
    assert_eq!(peer.says(), "ready");
    let shm = world.open();
    let mut reader =
        shm.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    peer.tell("12");
    assert_eq!(peer.says(), "sent");
    let mut got = Record::new(&state());
    eventually("the sample arrives", || reader.read(&mut got) == Ok(Reading::New));
    assert_eq!(number(&got), 12);
    // What the peer's service cannot hold is refused with the reason.
    let deep = shm.subscription(&PortSpec::new(&position(), &state()), Policy::Ring(10)).err();
    assert!(matches!(deep, Some(OpenError::Unsupported { .. })), "{deep:?}");
    let taken = shm.publisher(&PortSpec::new(&position(), &state())).err();
    assert_eq!(taken, Some(OpenError::Taken { address: position() }));
    // The message names the peer's type, although the peer has no genomd attributes.
    match shm.subscription(&PortSpec::new(&position(), &basic(Kind::Double)), Policy::Latest).err()
    {
        Some(OpenError::TypeMismatch { ours, theirs, .. }) => {
            assert!(ours.contains("double") && theirs.contains("demo::state"), "{ours}; {theirs}");
        }
        other => panic!("not refused for its type: {other:?}"),
    }
    peer.end();
}

#[test]
fn a_typed_peer_with_another_type_is_refused_by_iceoryx2() {
    let world = ShmWorld::new();
    let shm = world.open();
    let _writer = shm.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let peer = Process::start(PEER, &world, &["wrong", "demo/position"]);
    assert_eq!(peer.says(), "IncompatibleTypes");
    peer.end();
}

#[test]
fn what_a_peer_writes_wrong_is_refused_and_counted_and_the_value_stays() {
    let world = ShmWorld::new();
    let shm = world.open();
    let mut reader =
        shm.subscription(&PortSpec::new(&position(), &note()), Policy::Latest).unwrap();
    let mut peer = Process::start(PEER, &world, &["write-bytes", "demo/position"]);
    assert_eq!(peer.says(), "ready");
    let mut good = Vec::new();
    let mut value = Record::new(&note());
    value.merge_json(&json!({"text": "hi", "rows": [[1, 2], []]})).unwrap();
    value.encode_message(&mut good).unwrap();
    let mut send = |bytes: &[u8]| {
        let words: Vec<String> = bytes.iter().map(u8::to_string).collect();
        peer.tell(&words.join(" "));
        assert_eq!(peer.says(), "sent");
    };
    let mut got = Record::new(&note());
    send(&good);
    eventually("the note arrives", || reader.read(&mut got) == Ok(Reading::New));
    assert_eq!(got.to_json(), value.to_json());
    // Truncated at every length, and with a length field that exceeds the sample.
    let mut wrong: Vec<Vec<u8>> = (1..good.len()).map(|end| good[..end].to_vec()).collect();
    wrong.push([&good[..4], &[255, 255, 255, 255], &good[8..]].concat());
    for (n, bytes) in wrong.iter().enumerate() {
        send(bytes);
        let mut reading = Ok(Reading::Same);
        eventually("the sample is refused", || {
            reading = reader.read(&mut got);
            reading != Ok(Reading::Same)
        });
        assert_eq!(reading, Err(ReadError::Serialization), "{bytes:?}");
        assert_eq!(reader.dropped(), n as u64 + 1);
        assert_eq!(got.to_json(), value.to_json());
    }
    send(&good);
    eventually("the note arrives", || reader.read(&mut got) == Ok(Reading::New));
    peer.end();
}
