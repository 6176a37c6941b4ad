//! Peers that send invalid data: a DDS writer of raw bytes, under ROS names.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

mod raw;
mod world;

use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use genom_conformance::eventually;
use genom_conformance::samples::{note, note_of, number, numbered, small, state};
use genom_middleware::{
    ActivityId, Address, Middleware, Outcome, Policy, PortSpec, ReadError, Reading, Replies,
    ServiceHandler, ServiceKind, ServiceType, Services, Subscription,
};
use genom_ros2::ServiceMapping;
use genom_types::{DataType, Kind, Label, Member, Record, ScopedName, TypeTable, UnionMember};
use raw::{Encoding, Newer, Noise, Parameters, Peer, Plain, SEED, Text, Writer};
use serde_json::json;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record as Fields};
use tracing::{Event, Level, Metadata};
use world::Domain;

/// The CDR payload of a value.
fn payload(value: &Record) -> Vec<u8> {
    let mut message = Vec::new();
    value.encode_message(&mut message).unwrap();
    message.split_off(4)
}

/// Waits until the reader has read a sample or refused one.
fn outcome(reader: &mut dyn Subscription, got: &mut Record) -> Result<(), ReadError> {
    let mut outcome = Ok(());
    eventually("it is read or refused", || match reader.read(got) {
        Ok(reading) => reading == Reading::New,
        Err(error) => {
            outcome = Err(error);
            true
        }
    });
    outcome
}

/// An in port that receives from a raw writer.
struct Victim {
    reader: Box<dyn Subscription>,
    got: Record,
    good: Vec<u8>,
    refused: u64,
}

impl Victim {
    fn new(ros2: &dyn Middleware, value: &Record) -> Self {
        Self::at(ros2, &Address::new("demo", "position"), value)
    }

    fn at(ros2: &dyn Middleware, at: &Address, value: &Record) -> Self {
        let ty = value.ty();
        Self {
            reader: ros2.subscription(&PortSpec::new(at, ty), Policy::Queue(4)).unwrap(),
            got: Record::new(ty),
            good: payload(value),
            refused: 0,
        }
    }

    /// Sends a message, and checks that it is either read or refused and counted.
    fn suffers<E: Encoding>(&mut self, writer: &Writer<E>, message: Vec<u8>) -> bool {
        writer.write(message);
        let outcome = outcome(&mut *self.reader, &mut self.got);
        assert!(matches!(outcome, Ok(()) | Err(ReadError::Serialization)), "{outcome:?}");
        self.refused += u64::from(outcome.is_err());
        assert_eq!(self.reader.dropped(), self.refused);
        outcome.is_ok()
    }
}

fn is_fuzzed(value: &Record, dds_type: &str) {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    let mut victim = Victim::new(&*ros2, value);
    let writer = peer.writer::<Plain>("rt/demo/position", dds_type);
    peer.connected(&writer);
    let (good, mut noise) = (victim.good.clone(), Noise(SEED));
    assert!(victim.suffers(&writer, good.clone()), "a good one is read");
    assert!(!victim.suffers(&writer, Vec::new()), "one of no bytes is not");
    for _ in 0..1500 {
        victim.suffers(&writer, noise.spoil(&good));
    }
    assert!(victim.refused > 300, "most of it is nonsense: {}", victim.refused);
    assert!(victim.suffers(&writer, good), "after all that a good one is read");
    assert_eq!(victim.got.to_json(), value.to_json());
}

#[test]
fn nonsense_of_a_fixed_type_is_refused_and_counted() {
    is_fuzzed(&numbered(7), "demo::msg::dds_::State_");
}

#[test]
fn nonsense_of_strings_and_sequences_is_refused_and_counted() {
    let mut value = Record::new(&note());
    value.merge_json(&note_of(6)).unwrap();
    is_fuzzed(&value, "demo::msg::dds_::Note_");
}

#[test]
fn types_of_less_than_a_word_are_read_at_any_length_but_none() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    for (ty, values) in small() {
        let name = ty.name().trim_start_matches("::demo::");
        let mut value = Record::new(&ty);
        value.merge_json(&json!({ "it": values[0] })).unwrap();
        let mut victim = Victim::at(&*ros2, &Address::new("demo", name), &value);
        let dds_type = format!("demo::msg::dds_::{}{}_", name[..1].to_uppercase(), &name[1..]);
        let writer = peer.writer::<Plain>(&format!("rt/demo/{name}"), &dds_type);
        peer.connected(&writer);
        let good = victim.good.clone();
        assert!((1..4).contains(&good.len()), "{name}");
        assert!(!victim.suffers(&writer, Vec::new()), "{name}");
        assert!(victim.suffers(&writer, good.clone()), "{name}");
        assert_eq!(victim.got.to_json(), value.to_json());
        // DDS pads messages to multiples of 4 bytes; the padding is not part of the value.
        for more in 0..8 {
            let longer = [&good[..], &vec![0xff; more]].concat();
            assert!(victim.suffers(&writer, longer), "{name} and {more} bytes");
            assert_eq!(victim.got.to_json(), value.to_json());
        }
    }
}

#[test]
fn the_next_sample_is_read_after_messages_cut_within_their_first_word() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    let mut victim = Victim::new(&*ros2, &numbered(7));
    let writer = peer.writer::<Plain>("rt/demo/position", "demo::msg::dds_::State_");
    peer.connected(&writer);
    let good = victim.good.clone();
    assert!(victim.suffers(&writer, good.clone()));
    let other = [&[0, 1, 0, 0], &payload(&numbered(8))[..]].concat();
    // Sent as that writer's next sample.
    for message in [&[][..], &[0], &[0, 1], &[0, 1, 0]] {
        peer.forge(&domain, &writer, 2, message);
    }
    eventually("the whole one is read", || {
        peer.forge(&domain, &writer, 2, &other);
        victim.reader.read(&mut victim.got) == Ok(Reading::New)
    });
    assert_eq!(number(&victim.got), 8);
    // The writer's own second sample has the same number and comes too late.
    writer.write(good.clone());
    assert!(victim.suffers(&writer, good));
    assert_eq!(number(&victim.got), 7);
}

/// `::demo::command`: a mode and a union selected by it, with one optional member.
fn command() -> DataType {
    let mut table = TypeTable::default();
    let name = |name: &str| ScopedName::new(["demo", name]);
    let enumerators = ["halt", "turn", "tell"].map(str::to_owned).to_vec();
    let mode = table.add(Kind::Enum { name: name("mode"), enumerators });
    let double = table.add(Kind::Double);
    let text = table.add(Kind::String { bound: Some(16) });
    let maybe = table.add(Kind::Optional { element: double });
    let member =
        |name: &str, ty, label| UnionMember { name: name.to_owned(), ty, labels: vec![label] };
    let what = table.add(Kind::Union {
        name: name("what"),
        discriminant: mode,
        members: vec![
            member("angle", maybe, Label::Value(1)),
            member("text", text, Label::Value(2)),
        ],
    });
    let member = |name: &str, ty| Member { name: name.to_owned(), ty };
    let members = vec![member("mode", mode), member("what", what)];
    let id = table.add(Kind::Struct { name: name("command"), members });
    DataType::new(&Arc::new(table), id).unwrap()
}

#[test]
fn nonsense_of_enums_unions_and_optionals_is_refused_and_counted() {
    let mut value = Record::new(&command());
    value
        .merge_json(&json!({"mode": "tell", "what": {"d": "tell", "u": {"text": "bonjour"}}}))
        .unwrap();
    is_fuzzed(&value, "demo::msg::dds_::Command_");
}

#[test]
fn wrong_discriminators_lengths_and_texts_are_refused_one_by_one() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    let mut value = Record::new(&command());
    value
        .merge_json(&json!({"mode": "tell", "what": {"d": "tell", "u": {"text": "bonjour"}}}))
        .unwrap();
    let mut victim = Victim::new(&*ros2, &value);
    let writer = peer.writer::<Plain>("rt/demo/position", "demo::msg::dds_::Command_");
    peer.connected(&writer);
    let good = victim.good.clone();
    // Mode, discriminant, number of angles, number of texts, length of the text, text.
    let text = good.len() - "bonjour\0".len();
    for (what, at, word) in [
        ("an enumerator beyond the last", 0, 3u32),
        ("a negative one", 0, u32::MAX),
        ("a discriminant beyond the last", 4, 99),
        ("a text longer than the message", text - 4, 9),
        ("a text longer than all memory", text - 4, u32::MAX),
        ("a text that is no UTF-8", text, 0xffff_ffff),
        ("two values of an optional", text - 8, 2),
        ("all values there can be", text - 8, u32::MAX),
    ] {
        let mut bad = good.clone();
        bad[at..at + 4].copy_from_slice(&word.to_le_bytes());
        assert!(!victim.suffers(&writer, bad), "{what}");
    }
    // Messages are padded to 4 bytes, so what is cut within the last word is filled with zeros.
    for end in 0..=good.len() - 4 {
        assert!(!victim.suffers(&writer, good[..end].to_vec()), "{end} bytes are too few");
    }
    assert!(victim.suffers(&writer, good));
}

#[test]
fn samples_in_another_encapsulation_are_refused_and_counted() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    let mut victim = Victim::new(&*ros2, &numbered(7));
    fn all<E: Encoding>(victim: &mut Victim, peer: &Peer) -> Vec<bool> {
        let writer = peer.writer::<E>("rt/demo/position", "demo::msg::dds_::State_");
        peer.connected(&writer);
        let good = victim.good.clone();
        [good, Vec::new()].map(|message| victim.suffers(&writer, message)).to_vec()
    }
    assert_eq!(all::<Parameters>(&mut victim, &peer), [false, false]);
    assert_eq!(all::<Newer>(&mut victim, &peer), [false, false]);
    assert_eq!(all::<Text>(&mut victim, &peer), [false, false]);
    assert_eq!(all::<Plain>(&mut victim, &peer), [true, false]);
    assert_eq!(number(&victim.got), 7);
}

/// Log lines about undecodable samples of [`NOISY`]: the count in each line.
#[derive(Default)]
struct Log(Mutex<Vec<u64>>);

const NOISY: &str = "rt/demo/noisy";

/// The fields of one line.
#[derive(Default)]
struct Line {
    topic: String,
    samples: u64,
}

impl Visit for Line {
    fn record_u64(&mut self, field: &Field, value: u64) {
        if field.name() == "samples" {
            self.samples = value;
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "topic" {
            self.topic = format!("{value:?}");
        }
    }
}

impl tracing::Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN && metadata.target().starts_with("genom_ros2")
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Fields<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut line = Line::default();
        event.record(&mut line);
        if line.topic == NOISY {
            self.0.lock().unwrap().push(line.samples);
        }
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

#[test]
fn the_log_tells_of_all_bad_samples_in_one_line_a_second() {
    let log = Arc::<Log>::default();
    tracing::subscriber::set_global_default(Arc::clone(&log)).unwrap();
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer) = (domain.open(), Peer::new(&domain));
    let mut victim = Victim::at(&*ros2, &Address::new("demo", "noisy"), &numbered(7));
    let writer = peer.writer::<Plain>(NOISY, "demo::msg::dds_::State_");
    peer.connected(&writer);
    let begun = Instant::now();
    for _ in 0..400 {
        assert!(!victim.suffers(&writer, vec![1, 2, 3]));
    }
    let lines = || log.0.lock().unwrap().clone();
    eventually("the last one is told of", || lines().last() == Some(&400));
    let (lines, seconds) = (lines(), begun.elapsed().as_secs_f64());
    assert!(lines.is_sorted(), "{lines:?}");
    // The first line comes at once.
    assert!(lines.len() as f64 <= seconds + 1.0, "{lines:?} in {seconds} s");
}

/// Counts its requests and does nothing else.
#[derive(Default)]
struct Listener {
    heard: AtomicU64,
    last: AtomicU64,
}

impl ServiceHandler for Listener {
    fn request(&self, input: Record, mut replies: Box<dyn Replies>) {
        // A valid message with a few bytes changed may decode as a state with any count.
        let count = input.to_json()["count"].as_u64().unwrap();
        let heard = self.heard.fetch_add(1, Ordering::SeqCst) + 1;
        self.last.store(count, Ordering::SeqCst);
        replies.accepted(ActivityId(heard));
        replies.finish(Outcome::Success(numbered(1)));
    }

    fn cancel(&self, _: ActivityId) {}
}

const LAST: u64 = 4242;

/// Serves a service, sends it invalid requests under these names, then a valid one.
fn survives(kind: ServiceKind, topic: &str, dds_type: &str, before: &[u8]) {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let (ros2, peer, other) = (domain.open(), Peer::new(&domain), domain.open());
    let ty = ServiceType::new(kind, state(), state());
    let at = Address::new("demo", "goto");
    let handler = Arc::<Listener>::default();
    let _served = ros2.serve(&at, &ty, handler.clone()).unwrap();
    let writer = peer.writer::<Plain>(topic, dds_type);
    peer.connected(&writer);
    let (good, mut noise) = ([before, &payload(&numbered(7))].concat(), Noise(SEED));
    writer.write(Vec::new());
    for _ in 0..1000 {
        writer.write(noise.spoil(&good));
    }
    // Requests arrive in order: once the last one arrived, all did.
    let mut id = before.to_vec();
    id.iter_mut().for_each(|byte| *byte = 0xaa);
    writer.write([&id, &payload(&numbered(LAST))[..]].concat());
    eventually("the last one is heard", || handler.last.load(Ordering::SeqCst) == LAST);
    assert!(handler.heard.load(Ordering::SeqCst) < 800, "what is nonsense is not handed on");
    let mut client = other.client(&at, &ty).unwrap();
    match client.call(&numbered(9), Duration::from_secs(60)) {
        Ok(Outcome::Success(output)) => assert_eq!(number(&output), 1),
        other => panic!("it serves no more: {other:?}"),
    }
}

#[test]
fn a_service_survives_requests_that_are_nonsense() {
    survives(ServiceKind::Function, "rq/demo/gotoRequest", "demo::srv::dds_::Goto_Request_", &[]);
}

#[test]
fn an_action_survives_goals_that_are_nonsense() {
    survives(
        ServiceKind::Activity,
        "rq/demo/goto/_action/send_goalRequest",
        "demo::action::dds_::Goto_SendGoal_Request_",
        &[7; 16],
    );
}
