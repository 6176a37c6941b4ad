//! Which types and sizes are carried, and which mismatches are refused.

use std::sync::Arc;

use genom_types::{DataType, Kind, Record};
use serde_json::{Value, json};

use crate::harness::{World, eventually};
use crate::ports::{position, reader, writer};
use crate::samples::{LARGE, basic, image, note, note_of, other_state, state, twin};
use genom_middleware::{
    Address, Middleware, OpenError, Policy, PortSpec, Publisher, Reading, Subscription,
};

/// Opens an end until it is refused because of its type; checks that the error names both types.
#[track_caller]
fn refused<T>(ours: &DataType, theirs: &DataType, mut open: impl FnMut() -> Result<T, OpenError>) {
    eventually("the other type is refused", || match open() {
        // Middlewares that discover in the background may not have seen the other end yet.
        Ok(_) => false,
        Err(OpenError::TypeMismatch { address, ours: mine, theirs: other }) => {
            assert_eq!(address, position());
            assert!(mine.contains(ours.name()), "{mine} names {ours}");
            assert!(other.contains(theirs.name()), "{other} names {theirs}");
            assert_ne!(mine, other, "the two can be told apart");
            true
        }
        Err(other) => panic!("refused for another reason: {other}"),
    });
}

/// A reader of another type is refused.
pub fn another_type_is_refused_with_both_named(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let _writer = writer(&a);
    for ty in [basic(Kind::Double), basic(Kind::Octet)] {
        refused(&ty, &state(), || b.subscription(&PortSpec::new(&position(), &ty), Policy::Latest));
    }
    drop(
        b.subscription(&PortSpec::new(&position(), &state()), Policy::Latest)
            .expect("the right type"),
    );
}

/// A writer of another type is refused if the reader was opened first.
pub fn a_writer_of_another_type_is_refused_with_both_named(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let _reader = reader(&b, Policy::Latest);
    let ty = basic(Kind::Double);
    refused(&ty, &state(), || a.publisher(&PortSpec::new(&position(), &ty)));
    drop(a.publisher(&PortSpec::new(&position(), &state())).expect("the right type"));
}

/// Equal name and size are not enough: the digest decides (genom3.md 4.9).
pub fn types_of_one_name_and_other_members_are_refused(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    assert_eq!((state().name(), state().size()), (other_state().name(), other_state().size()));
    let _writer = writer(&a);
    refused(&other_state(), &state(), || {
        b.subscription(&PortSpec::new(&position(), &other_state()), Policy::Latest)
    });
}

/// Equal names are not needed: two components may each define a type with these members (genom3.md
/// 4.9).
pub fn types_of_other_names_and_equal_members_connect(world: &dyn World) {
    assert_eq!(state().digest(), twin().digest());
    let (a, b) = (world.join(), world.join());
    for (n, (first, second)) in [(state(), twin()), (twin(), state())].into_iter().enumerate() {
        let at = Address::new("demo", format!("position{n}"));
        let policies = [Policy::Latest, Policy::Queue(4)];
        // First the reader is opened first, then the writer.
        let early = b.subscription(&PortSpec::new(&at, &first), policies[n]).expect("an in port");
        let mut writer = a.publisher(&PortSpec::new(&at, &second)).expect("an out port");
        let late =
            b.subscription(&PortSpec::new(&at, &first), policies[1 - n]).expect("an in port");
        let mut sent = Record::new(&second);
        sent.merge_json(&json!({"count": 7, "values": [1, 2, 3, 4, 5, 6, 7]})).expect("a value");
        writer.publish(&sent).expect("published");
        let mut got = Record::new(&first);
        for mut reader in [early, late] {
            eventually("the value arrives", || reader.read(&mut got) == Ok(Reading::New));
            assert_eq!(got.to_json(), sent.to_json());
        }
    }
}

type Ends = (Box<dyn Publisher>, Box<dyn Subscription>);

/// Opens both ends; `None` if the backend cannot carry the type, after checking that it says why.
fn open(world: &dyn World, ty: &DataType) -> Option<(Vec<Arc<dyn Middleware>>, Ends)> {
    let (a, b) = (world.join(), world.join());
    let at = Address::new("demo", "value");
    if !ty.is_fixed_size() && !a.capabilities().variable_size {
        for error in [
            a.publisher(&PortSpec::new(&at, ty)).err(),
            b.subscription(&PortSpec::new(&at, ty), Policy::Latest).err(),
        ] {
            match error {
                Some(OpenError::Unsupported { ty: named, why, .. }) => {
                    assert!(named.contains(ty.name()) && !why.is_empty());
                }
                other => panic!("{ty} is neither carried nor refused: {other:?}"),
            }
        }
        return None;
    }
    let ends = (
        a.publisher(&PortSpec::new(&at, ty)).expect("an out port"),
        b.subscription(&PortSpec::new(&at, ty), Policy::Latest).expect("an in port"),
    );
    Some((vec![a, b], ends))
}

/// Sends values one by one, and checks that each arrives unchanged.
#[track_caller]
fn travel(world: &dyn World, ty: &DataType, values: impl IntoIterator<Item = Value>) {
    let Some((_backends, (mut writer, mut reader))) = open(world, ty) else { return };
    let mut got = Record::new(ty);
    for value in values {
        let mut sent = Record::new(ty);
        sent.merge_json(&value).expect("a value of the type");
        writer.publish(&sent).expect("published");
        eventually("the value arrives", || reader.read(&mut got).expect("read") == Reading::New);
        assert_eq!(got.to_json(), sent.to_json());
    }
}

/// Unbounded strings, and sequences within sequences.
pub fn strings_and_nested_sequences_travel(world: &dyn World) {
    travel(world, &note(), [0, 1, 2, 9, 0, 40].map(note_of));
}

/// Values that grow a lot and shrink again.
pub fn growing_values_travel(world: &dyn World) {
    travel(world, &note(), (0..15).map(|n| note_of(1 << n)));
    travel(world, &note(), (0..15).rev().map(|n| note_of(1 << n)));
}

/// Backends that take and give messages in CDR, for who passes samples on, mean the same by them as
/// by records; bytes that are no value of the type go nowhere.
pub fn messages_travel_as_the_records_that_they_are(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (at, ty) = (position(), note());
    let port = PortSpec::new(&at, &ty);
    let mut writer = a.publisher(&port).unwrap();
    let mut reader = b.subscription(&port, Policy::Latest).unwrap();
    let (mut sent, mut got) = (Record::new(&ty), Record::new(&ty));
    for rows in 1..12 {
        sent.merge_json(&note_of(rows)).unwrap();
        let mut message = Vec::new();
        sent.encode_message(&mut message).unwrap();
        let wrong = message.split_last().map_or(&[][..], |(_, rest)| rest);
        if let Some(published) = writer.publish_message(wrong) {
            assert!(published.is_err(), "it is cut");
            let padded = [&message[..], &[0; 3]].concat();
            writer.publish_message(&padded).unwrap().unwrap();
        } else {
            writer.publish(&sent).unwrap();
        }
        let mut read = Vec::new();
        eventually("the sample arrives", || match reader.read_message(&mut read) {
            Some(reading) => reading.unwrap() == Reading::New && got.decode_message(&read).is_ok(),
            None => reader.read(&mut got).unwrap() == Reading::New,
        });
        assert_eq!(got.to_json(), note_of(rows));
    }
    assert_eq!(reader.dropped(), 0);
}

/// Samples of 4 MiB arrive complete, several times.
pub fn samples_of_4_mib_travel(world: &dyn World) {
    let ty = image();
    let Some((_backends, (mut writer, mut reader))) = open(world, &ty) else { return };
    let (mut sent, mut got) = (Record::new(&ty), Record::new(&ty));
    for round in 1..=8u8 {
        let pixels: Vec<u8> = (0..LARGE).map(|i| (i as u8).wrapping_mul(round)).collect();
        sent.set_bytes(&pixels).expect("the bytes of an image");
        writer.publish(&sent).expect("published");
        eventually("the image arrives", || reader.read(&mut got).expect("read") == Reading::New);
        assert!(got.bytes() == sent.bytes(), "image {round} arrives as it was");
    }
}

/// Types without a name, such as `double`.
pub fn basic_types_travel(world: &dyn World) {
    for (kind, value) in [
        (Kind::Boolean, json!(true)),
        (Kind::Char, json!(65)),
        (Kind::Octet, json!(255)),
        (Kind::Short, json!(-2)),
        (Kind::UnsignedShort, json!(65535)),
        (Kind::Long, json!(-3)),
        (Kind::UnsignedLong, json!(4_294_967_295_u32)),
        (Kind::LongLong, json!(-4)),
        (Kind::UnsignedLongLong, json!(1_u64 << 63)),
        (Kind::Float, json!(0.5)),
        (Kind::Double, json!(-0.25)),
        (Kind::String { bound: Some(8) }, json!("seven c")),
        (Kind::String { bound: None }, json!("any length")),
    ] {
        travel(world, &basic(kind), [value]);
    }
}
