//! Sessions of zenoh that send what no ROS node does.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "test code, also outside of test functions"
)]

#[path = "world/services.rs"]
mod services;
#[path = "world/zenoh.rs"]
mod world;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_conformance::eventually;
use genom_conformance::samples::{note, note_of, numbered, state};
use genom_middleware::{
    ActivityId, Address, CallError, Discovery, Middleware, Outcome, Policy, PortSpec, Ports,
    Reading, Replies, ServiceHandler, Services, Subscription,
};
use genom_ros2::{Options, Ros2};
use genom_types::{DataType, Record};
use services::reset;
use world::Place;
use zenoh::Wait;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;

/// A session of plain zenoh that is connected to the router.
struct Attacker(zenoh::Session);

impl Attacker {
    fn new(place: &Place) -> Self {
        let mut config = zenoh::Config::default();
        for (key, value) in [
            ("mode", "\"client\"".to_owned()),
            ("connect/endpoints", format!("[{:?}]", place.router())),
            ("listen/endpoints", "[]".to_owned()),
            ("scouting/multicast/enabled", "false".to_owned()),
            // As from another machine.
            ("transport/shared_memory/enabled", "false".to_owned()),
        ] {
            config.insert_json5(key, &value).unwrap();
        }
        Self(zenoh::open(config).wait().unwrap())
    }

    /// The key of the topic or service of an end, as soon as its token is known.
    fn key(&self, kind: &str, name: &str) -> String {
        let tokens = format!("@ros2_lv/0/*/*/*/{kind}/**");
        let mut found = None;
        eventually("its token is known", || {
            let replies = self.0.liveliness().get(&tokens).wait().unwrap();
            while let Ok(reply) = replies.recv() {
                let Ok(sample) = reply.into_result() else { continue };
                let chunks: Vec<_> = sample.key_expr().as_str().split('/').collect();
                let of = chunks[9].replace('%', "/");
                if of == name {
                    found = Some(format!("0{of}/{}/{}", chunks[10], chunks[11]));
                }
            }
            found.is_some()
        });
        found.unwrap()
    }

    fn token(&self, key: impl Into<String>) -> LivelinessToken {
        self.0.liveliness().declare_token(key.into()).wait().unwrap()
    }

    fn put(&self, key: &str, message: &[u8], attachment: &[u8]) {
        let put = self.0.put(key, message).attachment(attachment);
        put.congestion_control(CongestionControl::Block).wait().unwrap();
    }
}

/// A token of an end of another session.
fn token(session: &str, number: usize, kind: &str, name: &str, ty: &str) -> String {
    let name = name.replace('/', "%");
    format!("@ros2_lv/0/{session}/0/{number}/{kind}/%/%/n/{name}/{ty}/RIHS01_1/::,7:,:,:,,")
}

/// What else a daemon tells of an out port.
fn told(session: &str, number: usize, digest: &str) -> String {
    format!("@genom_ros2/0/{session}/0/{number}/pub/{digest}/t/demo%2fposition")
}

/// The attachment of a sample of this number.
fn attachment(number: u64) -> Vec<u8> {
    [&number.to_le_bytes()[..], &[0; 8], &[16], &[7; 16]].concat()
}

/// How often something was refused for the reason with these words.
fn refused(ros2: &Ros2, words: &str) -> u64 {
    let all = ros2.refused();
    all.iter().find(|one| one.why.contains(words)).map_or(0, |one| one.count)
}

fn position() -> Address {
    Address::new("demo", "position")
}

fn message(value: &Record) -> Vec<u8> {
    let mut message = Vec::new();
    value.encode_message(&mut message).unwrap();
    message
}

fn reads(reader: &mut dyn Subscription, value: &Record) {
    let mut got = Record::new(value.ty());
    eventually("a good sample is read", || reader.read(&mut got) == Ok(Reading::New));
    assert_eq!(got.to_json(), value.to_json());
}

/// A deterministic pseudo-random number generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 32).unwrap()
    }

    /// The message with some bytes changed, and often cut.
    fn spoil(&mut self, message: &[u8]) -> Vec<u8> {
        let mut bad = message.to_vec();
        for _ in 0..self.next() % 4 {
            let at = self.next() % bad.len();
            bad[at] = self.next().to_le_bytes()[0];
        }
        if self.next().is_multiple_of(2) {
            bad.truncate(self.next() % bad.len());
        }
        bad
    }
}

/// Each of many corrupted messages is either read or refused and counted.
fn suffers(ty: &DataType, value: &Record) {
    let place = Place::new();
    let ros2 = place.open();
    let mut reader = ros2.subscription(&PortSpec::new(&position(), ty), Policy::Queue(4)).unwrap();
    let attacker = Attacker::new(&place);
    let key = attacker.key("MS", "/demo/position");
    let (message, mut got) = (message(value), Record::new(ty));
    let (mut noise, mut bad) = (Noise(0x9e37_79b9_7f4a_7c15), 0);
    for number in 1..1000 {
        attacker.put(&key, &noise.spoil(&message), &attachment(number));
        eventually("it is read or refused", || match reader.read(&mut got) {
            Ok(reading) => reading == Reading::New,
            Err(_) => {
                bad += 1;
                true
            }
        });
    }
    assert!(bad > 200, "most of it is nonsense: {bad}");
    assert_eq!(reader.dropped(), bad);
    attacker.put(&key, &message, &attachment(1000));
    reads(&mut *reader, value);
}

#[test]
fn nonsense_of_a_fixed_type_is_refused_and_counted() {
    suffers(&state(), &numbered(7));
}

#[test]
fn nonsense_of_strings_and_sequences_is_refused_and_counted() {
    let mut value = Record::new(&note());
    value.merge_json(&note_of(6)).unwrap();
    suffers(&note(), &value);
}

#[test]
fn samples_that_are_too_large_or_have_no_proper_attachment_are_refused_and_counted() {
    let place = Place::new();
    let ros2 = Ros2::open(&Options { greatest_sample: 4096, ..place.options() }).unwrap();
    let mut reader =
        ros2.subscription(&PortSpec::new(&position(), &state()), Policy::Queue(4)).unwrap();
    let attacker = Attacker::new(&place);
    let key = attacker.key("MS", "/demo/position");
    let (value, good) = (numbered(7), message(&numbered(7)));
    attacker.put(&key, &good, &attachment(1));
    reads(&mut *reader, &value);
    let mut longer = attachment(2);
    longer.push(0);
    let of_another_length = [&[0; 16][..], &[15], &[7; 16]].concat();
    for bad in [&attachment(2)[..32], &longer, &of_another_length, &[0; 33], &[9; 5000], b"x"] {
        attacker.put(&key, &good, bad);
    }
    attacker.put(&key, &[0; 4097], &attachment(2));
    eventually("all are refused", || reader.dropped() == 7);
    assert_eq!(refused(&ros2, "no attachment of rmw_zenoh"), 6);
    assert_eq!(refused(&ros2, "greatest_sample"), 1);
    // One far too large is left out while it arrives, and counted as lost with the next.
    attacker.put(&key, &vec![0; 3 << 20], &attachment(3));
    attacker.put(&key, &good, &attachment(4));
    reads(&mut *reader, &value);
    assert_eq!((reader.dropped(), refused(&ros2, "greatest_sample")), (8, 1));
}

#[test]
fn tokens_of_no_form_and_of_too_many_sessions_are_refused_and_the_rest_is_listed() {
    let place = Place::new();
    let ros2 = Ros2::open(&Options { participants: 8, ..place.options() }).unwrap();
    let attacker = Attacker::new(&place);
    let good = token("aa", 1, "MP", "/some/topic", "t::msg::dds_::T_");
    let long = token("aa", 1, "MP", &"/x".repeat(4000), "t::msg::dds_::T_");
    let bad = [
        "@ros2_lv/0/only",
        "@ros2_lv/0/aa/b/c/MP/%/%/n/%x/T/RIHS01_1/::,7:,:,:,,",
        "@ros2_lv/0/aa/0/99999999999999999999/MP/%/%/n/%x/T/RIHS01_1/::,7:,:,:,,",
        &good.replace("some", "\u{1b}[2J"),
        &long,
        "@genom_ros2/0/aa/0/1/pub/d",
        "@genom_ros2/0/aa/0/1/pub/d/%zz/x",
        "@genom_ros2/0/aa/0/1/pub/d/%1b%5b2J/x",
    ];
    let held = bad.map(|key| attacker.token(key));
    eventually("all are refused", || refused(&ros2, "no liveliness token") == 8);
    assert_eq!(ros2.discover().unwrap(), []);
    let sessions: Vec<_> = (0..40)
        .map(|n| format!("{n:032x}"))
        .map(|name| attacker.token(token(&name, 1, "MP", "/some/topic", "t::msg::dds_::T_")))
        .collect();
    eventually("the others are refused", || refused(&ros2, "sessions above") == 32);
    assert_eq!(ros2.discover().unwrap().len(), 8);
    drop((held, sessions));
    eventually("they are gone", || ros2.discover().unwrap().is_empty());
    let peer = place.open();
    let mut writer = peer.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let mut reader =
        ros2.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    writer.publish(&numbered(3)).unwrap();
    reads(&mut *reader, &numbered(3));
    eventually("it is listed", || ros2.discover().unwrap().len() == 2);
}

#[test]
fn who_tells_of_a_type_by_many_names_does_not_keep_others_from_being_read() {
    let place = Place::new();
    let ros2 = place.open();
    let mut reader =
        ros2.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    let attacker = Attacker::new(&place);
    let names = (0..100).flat_map(|n| {
        let ty = format!("demo::msg::dds_::T{n}_");
        [told("aa", n, state().digest()), token("aa", n, "MP", "/demo/position", &ty)]
    });
    let held: Vec<_> = names.map(|key| attacker.token(key)).collect();
    eventually("it does not read all", || refused(&ros2, "too many names") > 0);
    drop(held);
    let peer = place.open();
    let mut writer = None;
    eventually("the address is free", || {
        writer = peer.publisher(&PortSpec::new(&position(), &state())).ok();
        writer.is_some()
    });
    let mut writer = writer.unwrap();
    writer.publish(&numbered(3)).unwrap();
    reads(&mut *reader, &numbered(3));
}

/// Keeps requests without answering them.
#[derive(Default)]
struct Holds(Mutex<Vec<Box<dyn Replies>>>);

impl Holds {
    fn count(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}

impl ServiceHandler for Holds {
    fn request(&self, _: Record, replies: Box<dyn Replies>) {
        self.0.lock().unwrap().push(replies);
    }

    fn cancel(&self, _: ActivityId) {}
}

#[test]
fn requests_without_proper_attachment_or_above_the_limit_are_refused_and_the_next_is_served() {
    const MOST: usize = 1024;
    let place = Place::new();
    let ros2 = place.open();
    let holds = Arc::new(Holds::default());
    let at = Address::new("demo", "reset");
    let _served = ros2.serve(&at, &reset(), Arc::clone(&holds) as _).unwrap();
    let attacker = Attacker::new(&place);
    let key = attacker.key("SS", "/demo/reset");
    let answers = Arc::new(AtomicUsize::new(0));
    let ask = |attachment: &[u8]| {
        let asked = attacker.0.get(&key).payload([0_u8, 1, 0, 0, 0]).attachment(attachment);
        let answers = Arc::clone(&answers);
        let count = move |_| {
            answers.fetch_add(1, Ordering::Relaxed);
        };
        asked.timeout(Duration::from_secs(600)).callback(count).wait().unwrap();
    };
    for bad in [&attachment(1)[..32], &[9; 5000], b"x"] {
        ask(bad);
    }
    eventually("all are refused", || refused(&ros2, "no attachment of rmw_zenoh") == 3);
    assert_eq!(holds.count(), 0);
    (0..MOST + 10).for_each(|_| ask(&attachment(1)));
    eventually("the rest is refused", || refused(&ros2, "not answered yet") == 10);
    assert_eq!(holds.count(), MOST);
    let mut client = place.open().client(&at, &reset()).unwrap();
    let call = client.call(&Record::new(&reset().input), Duration::from_secs(60));
    assert!(matches!(call, Err(CallError::Gone)), "{call:?}");
    // Answers make room.
    let held = std::mem::take(&mut *holds.0.lock().unwrap());
    let done = || Outcome::Success(Record::new(&reset().output));
    held.into_iter().for_each(|replies| replies.finish(done()));
    eventually("all are answered", || answers.load(Ordering::Relaxed) == MOST);
    let answered = std::thread::spawn(move || {
        client.call(&Record::new(&reset().input), Duration::from_secs(60))
    });
    eventually("the next arrives", || {
        holds.0.lock().unwrap().drain(..).for_each(|replies| replies.finish(done()));
        answered.is_finished()
    });
    let answer = answered.join().unwrap();
    assert!(matches!(answer, Ok(Outcome::Success(_))), "{answer:?}");
}
