//! Who sends nonsense to a gateway loses its connection; nobody else does.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod world;

use std::io::{Read as _, Write as _};
use std::time::Duration;

use genom_conformance::ports::{read_until, reader, writer};
use genom_conformance::samples::numbered;
use genom_middleware::Policy;
use world::{House, Kind};

/// A frame of kind 1 with these words.
fn message(words: &str) -> Vec<u8> {
    let size = u32::try_from(words.len()).unwrap();
    let mut frame = (size + 5).to_le_bytes().to_vec();
    frame.push(1);
    frame.extend(size.to_le_bytes());
    frame.extend(words.as_bytes());
    frame
}

/// A sample for the end of this number.
fn sample(end: u32, bytes: &[u8]) -> Vec<u8> {
    let mut frame = u32::try_from(bytes.len() + 5).unwrap().to_le_bytes().to_vec();
    frame.push(0);
    frame.extend(end.to_le_bytes());
    frame.extend(bytes);
    frame
}

#[test]
fn nonsense_ends_its_connection_and_no_other() {
    let house = House::new(Kind::Zenoh, false);
    let _gateway = house.gateway(0);
    let proxy = house.proxy(0);
    let (mut out, mut seen) = (writer(&proxy), reader(&proxy, Policy::Latest));
    let hello = message(r#"{"Hello":{"protocol":1}}"#);
    let door = house.reach(0).door("zenoh");
    let open = |ty: &str| {
        let address = r#""address":{"instance":"a","name":"b"}"#;
        let quality = r#""quality":{"reliable":null,"depth":null,"transient_local":null}"#;
        message(&format!(
            r#"{{"Open":{{"end":1,"what":{{"Publisher":{{{address},"ty":{ty},{quality}}}}}}}}}"#
        ))
    };
    let fatal: [Vec<u8>; 6] = [
        vec![0xff; 64],
        sample(1, b"before the greeting"),
        [hello.clone(), vec![0xff; 64]].concat(),
        [hello.clone(), message("{}")].concat(),
        [hello.clone(), message(r#"{"Open":{"end":1,"what":{}}}"#)].concat(),
        [hello.clone(), hello.clone()].concat(),
    ];
    for (round, bytes) in fatal.iter().enumerate() {
        let mut stream = genom_gateway::knock(&door).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        // It may be closed before all of it was sent.
        let _ = stream.write_all(bytes);
        let mut rest = Vec::new();
        // Reset, where something was not read.
        let ended = stream.read_to_end(&mut rest);
        assert!(!ended.is_err_and(|error| error.kind() == std::io::ErrorKind::WouldBlock));
        out.publish(&numbered(round as u64 + 1)).unwrap();
        read_until(&mut *seen, round as u64 + 1);
    }
    // What is refused, and not the end of the connection.
    let mut stream = genom_gateway::knock(&door).unwrap();
    let endless = r#"{"types":[{"Typedef":{"name":["t"],"target":0}}],"digest":""}"#;
    let cut = r#"{"types":[{"Sequence":{"element":9,"bound":null}}],"digest":""}"#;
    let refused = [
        hello,
        open(endless),
        open(cut),
        sample(9, b"no such end"),
        message(r#"{"Close":{"end":9}}"#),
        message(r#"{"Request":{"end":9,"call":1}}"#),
        message(r#"{"Cancel":{"call":9}}"#),
        message(r#"{"Progress":{"call":9,"progress":"Success"}}"#),
        message(r#"{"Reply":{"call":9,"replied":true}}"#),
    ];
    stream.write_all(&refused.concat()).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let mut heard = Vec::new();
    let mut buffer = [0; 4096];
    let told = |heard: &[u8], what: &str| String::from_utf8_lossy(heard).matches(what).count();
    while told(&heard, "Refused") < 2 || told(&heard, "Closed") < 1 || told(&heard, "Gone") < 1 {
        let read = stream.read(&mut buffer).unwrap();
        assert!(read > 0, "it ended: {}", String::from_utf8_lossy(&heard));
        heard.extend(&buffer[..read]);
    }
    out.publish(&numbered(100)).unwrap();
    read_until(&mut *seen, 100);
}
