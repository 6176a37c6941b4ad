//! A peer in Python with an independent CDR library does everything that genomd does.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code outside of test functions")]

mod world;

use std::collections::HashMap;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_components::peer::Lines;
use genom_conformance::samples::{number, numbered, state};
use genom_conformance::{World, eventually};
use genom_middleware::{
    ActivityId, Address, CallError, Discovery, EndpointKind, Outcome, Policy, PortSpec, Ports,
    ReadError, Reading, Replies, ServiceHandler, ServiceKind, ServiceType, Services, Stranger,
};
use genom_types::Record;
use serde_json::{Value, json};
use world::Meeting;

/// Only a failing test waits this long.
const WATCHDOG: Duration = Duration::from_secs(60);

/// Starts `peer.py`, connected to the session with this rendezvous folder.
fn start(place: &Meeting, what: &str) -> Lines {
    let packages = ["eclipse-zenoh==1.10.2", "cyclonedds==11.0.1"];
    let python = genom_components::python::environment(&packages)
        .unwrap_or_else(|error| panic!("the peer in Python cannot be had: {error}"));
    let socket = place.leftovers().into_iter().find(|path| path.ends_with(".sock")).unwrap();
    let mut command = Command::new(python);
    command
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"))
        .args([format!("unixsock-stream/{socket}").as_str(), what]);
    Lines::start(&mut command)
}

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn a_python_peer_reads_a_port_and_asks_for_its_last_value() {
    let place = Meeting::new();
    let zenoh = place.open();
    let mut writer = zenoh.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(41)).unwrap();
    let mut peer = start(&place, "read");
    peer.says("last 41");
    let said = format!("application/cdr;demo::state;digest={}", state().digest());
    for n in 42..50 {
        writer.publish(&numbered(n)).unwrap();
        peer.says(&format!("sample {n} {said} 16"));
    }
    peer.tell("end");
}

#[test]
fn a_peer_without_tokens_shows_as_a_session_and_as_a_reader() {
    let place = Meeting::new();
    let zenoh = place.open();
    let mut writer = zenoh.publisher(&PortSpec::new(&position(), &state())).unwrap();
    writer.publish(&numbered(1)).unwrap();
    let other = Address::new("demo", "other");
    let _other = zenoh.publisher(&PortSpec::new(&other, &state())).unwrap();
    assert_eq!(zenoh.strangers(), []);
    let mut peer = start(&place, "read");
    peer.says("last 1");
    let reads = Stranger::Reader { address: position().to_string() };
    let session = |one: &&Stranger| matches!(one, Stranger::Session { role, .. } if role == "peer");
    let alone = || {
        let seen = zenoh.strangers();
        seen.len() == 2 && seen.contains(&reads) && seen.iter().filter(session).count() == 1
    };
    eventually("the peer shows", alone);
    // A peer that has liveliness tokens is not listed as a stranger.
    let near = place.open();
    let _reader = near.subscription(&PortSpec::new(&other, &state()), Policy::Latest).unwrap();
    eventually("the reader shows", || {
        zenoh.discover().unwrap().iter().any(|end| end.kind == EndpointKind::Subscription)
    });
    assert!(alone(), "{:?}", zenoh.strangers());
    peer.tell("end");
    eventually("it is gone", || zenoh.strangers().is_empty());
}

#[test]
fn a_python_peer_writes_a_port_and_what_it_breaks_is_counted() {
    let place = Meeting::new();
    let zenoh = place.open();
    let mut reader =
        zenoh.subscription(&PortSpec::new(&position(), &state()), Policy::Queue(8)).unwrap();
    let mut peer = start(&place, "write");
    let mut got = Record::new(&state());
    for n in [5, 6] {
        peer.tell(&format!("put {n}"));
        peer.says("done");
        eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
        assert_eq!(number(&got), n);
    }
    let bad = ["broken 0", "broken 3", "broken 4", "broken 30", "broken 67", "other"];
    for (count, bad) in bad.iter().enumerate() {
        assert_eq!(reader.dropped(), count as u64);
        peer.tell(bad);
        peer.says("done");
        eventually("the bad sample is refused", || {
            reader.read(&mut got) == Err(ReadError::Serialization)
        });
        assert_eq!(number(&got), 6, "the value read before is kept");
    }
    assert_eq!(reader.dropped(), bad.len() as u64);
    peer.tell("put 7");
    eventually("the next one arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(number(&got), 7);
}

/// Adds 1000 at once, or runs until it is cancelled.
#[derive(Default)]
struct Adder {
    running: Mutex<HashMap<ActivityId, Box<dyn Replies>>>,
    activity: bool,
}

impl ServiceHandler for Adder {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        let n = number(&input);
        if self.activity {
            let mut running = self.running.lock().unwrap();
            replies.accepted(ActivityId(n));
            replies.feedback("::demo::start");
            replies.feedback("::demo::main");
            running.insert(ActivityId(n), replies);
        } else if n == 100 {
            let name = "::demo::TOO_FAR_AWAY".to_owned();
            replies.finish(Outcome::Exception { name, detail: json!({"distance": 1.5}) });
        } else {
            replies.finish(Outcome::Success(numbered(n + 1000)));
        }
    }

    fn cancel(&self, id: ActivityId) {
        if let Some(replies) = self.running.lock().unwrap().remove(&id) {
            let name = "::genom::interrupted".to_owned();
            replies.finish(Outcome::Exception { name, detail: Value::Null });
        }
    }
}

fn service(kind: ServiceKind) -> ServiceType {
    ServiceType::new(kind, state(), state())
}

#[test]
fn a_python_peer_calls_a_service() {
    let place = Meeting::new();
    let zenoh = place.open();
    let at = Address::new("demo", "add");
    let function = service(ServiceKind::Function);
    let _served = zenoh.serve(&at, &function, Arc::new(Adder::default())).unwrap();
    let peer = start(&place, "call");
    let digest = state().digest().to_owned();
    peer.says(&format!("result 1005 application/cdr;demo::state;digest={digest}"));
    peer.says(r#"error {"detail": {"distance": 1.5}, "exception": "::demo::TOO_FAR_AWAY"}"#);
    let line = peer.line("what is malformed");
    assert!(line.contains(r#""error": "serialization""#), "{line}");
    peer.says("end");
}

#[test]
fn a_python_peer_runs_an_activity_and_cancels_it() {
    let place = Meeting::new();
    let zenoh = place.open();
    let at = Address::new("demo", "goto");
    let handler = Arc::new(Adder { activity: true, ..Adder::default() });
    let _served = zenoh.serve(&at, &service(ServiceKind::Activity), handler).unwrap();
    let peer = start(&place, "run");
    peer.says("accepted 7");
    peer.says("feedback ::demo::start");
    peer.says("feedback ::demo::main");
    // The reply to the cancellation, then the end of the cancelled activity.
    peer.says("- ");
    peer.says("error ::genom::interrupted");
    let line = peer.line("what is malformed");
    assert!(line.contains(r#""error": "serialization""#), "{line}");
    peer.says("end");
}

#[test]
fn a_python_peer_serves() {
    let place = Meeting::new();
    let zenoh = place.open();
    let mut client =
        zenoh.client(&Address::new("demo", "add"), &service(ServiceKind::Function)).unwrap();
    let mut peer = start(&place, "serve");
    peer.says("ready");
    let mut outcome = None;
    eventually("the peer answers", || match client.call(&numbered(5), WATCHDOG) {
        Ok(answer) => {
            outcome = Some(answer);
            true
        }
        Err(CallError::Nobody { .. }) => false,
        Err(other) => panic!("{other}"),
    });
    assert!(matches!(outcome, Some(Outcome::Success(output)) if number(&output) == 1005));
    match client.call(&numbered(100), WATCHDOG).unwrap() {
        Outcome::Exception { name, detail } => {
            assert_eq!((name.as_str(), detail), ("::demo::TOO_FAR_AWAY", json!({"d": 1})));
        }
        other => panic!("no exception: {other:?}"),
    }
    match client.call(&numbered(101), WATCHDOG) {
        Err(CallError::Failed { why, .. }) => assert!(why.contains("out of order"), "{why}"),
        other => panic!("no failure: {other:?}"),
    }
    assert!(matches!(client.call(&numbered(102), WATCHDOG), Err(CallError::Serialization(_))));
    peer.tell("end");
}
