//! CDR of hand-written types, compared with another implementation, and hostile messages.

#![allow(clippy::unwrap_used)] // also in helpers, where clippy.toml does not reach

use std::sync::Arc;

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::{from_bytes, to_vec};
use genom_types::{CdrProblem, DataType, Kind, Member, Record, ScopedName, TypeId, TypeTable};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

#[derive(Serialize, Deserialize, PartialEq, Debug)]
struct Point {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize, Deserialize, PartialEq, Debug)]
struct Pose {
    position: Point,
    orientation: [f64; 4],
}

#[derive(Serialize, Deserialize, PartialEq, Debug)]
struct Reading {
    ok: bool,
    rank: u16,
    name: String,
    stamp: i64,
    pose: Pose,
    path: Vec<Point>,
    notes: Vec<String>,
    raw: Vec<u8>,
    small: Vec<(u8, i32)>,
    maybe: Vec<f32>,
    last: u8,
}

fn strukt(t: &mut TypeTable, name: &str, members: &[(&str, TypeId)]) -> TypeId {
    let members = members.iter().map(|&(name, ty)| Member { name: name.to_owned(), ty }).collect();
    t.add(Kind::Struct { name: ScopedName::new([name]), members })
}

fn reading() -> DataType {
    let mut t = TypeTable::default();
    let double = t.add(Kind::Double);
    let octet = t.add(Kind::Octet);
    let float = t.add(Kind::Float);
    let long = t.add(Kind::Long);
    let string = t.add(Kind::String { bound: None });
    let point = strukt(&mut t, "point", &[("x", double), ("y", double), ("z", double)]);
    let four = t.add(Kind::Array { element: double, length: 4 });
    let pose = strukt(&mut t, "pose", &[("position", point), ("orientation", four)]);
    let pair = strukt(&mut t, "pair", &[("a", octet), ("b", long)]);
    let mut many = |element| t.add(Kind::Sequence { element, bound: None });
    let (path, notes, raw, small) = (many(point), many(string), many(octet), many(pair));
    let maybe = t.add(Kind::Optional { element: float });
    let members = [
        ("ok", t.add(Kind::Boolean)),
        ("rank", t.add(Kind::UnsignedShort)),
        ("name", t.add(Kind::String { bound: Some(16) })),
        ("stamp", t.add(Kind::LongLong)),
        ("pose", pose),
        ("path", path),
        ("notes", notes),
        ("raw", raw),
        ("small", small),
        ("maybe", maybe),
        ("last", octet),
    ];
    let id = strukt(&mut t, "reading", &members);
    DataType::new(&Arc::new(t), id).unwrap()
}

/// The same value for both implementations.
fn both(maybe: Vec<f32>) -> (Reading, Value) {
    let point = |x| Point { x, y: 2.0 * x, z: -x };
    let reading = Reading {
        ok: true,
        rank: 7,
        name: "élan".to_owned(),
        stamp: -5,
        pose: Pose { position: point(1.5), orientation: [0.0, 0.5, 0.25, 1.0] },
        path: vec![point(3.0), point(4.0)],
        notes: vec!["".to_owned(), "abc".to_owned(), "defgh".to_owned()],
        raw: vec![1, 2, 3],
        small: vec![(1, -1), (2, -2), (3, -3)],
        maybe,
        last: 9,
    };
    let mut json = serde_json::to_value(&reading).unwrap();
    json["small"] = json!([{"a": 1, "b": -1}, {"a": 2, "b": -2}, {"a": 3, "b": -3}]);
    json["maybe"] = reading.maybe.first().map_or(Value::Null, |&value| json!(value));
    (reading, json)
}

#[test]
fn bytes_are_those_of_another_implementation() {
    let ty = reading();
    for maybe in [vec![], vec![0.5]] {
        let (theirs, json) = both(maybe);
        let expected = to_vec::<_, LittleEndian>(&theirs).unwrap();
        let mut record = Record::new(&ty);
        record.merge_json(&json).unwrap();
        let mut ours = Vec::new();
        record.encode_cdr(&mut ours).unwrap();
        assert_eq!(ours, expected);
        let (read, _) = from_bytes::<Reading, LittleEndian>(&ours).unwrap();
        assert_eq!(read, theirs);
        let mut message = Vec::new();
        record.encode_message(&mut message).unwrap();
        assert_eq!(message, [&[0, 1, 0, 0], &expected[..]].concat());
        let big = to_vec::<_, BigEndian>(&theirs).unwrap();
        let mut other = Record::new(&ty);
        other.decode_message(&[&[0, 0, 0, 0], &big[..]].concat()).unwrap();
        assert_eq!(other.to_json(), json);
    }
}

fn problem(ty: &DataType, payload: &[u8]) -> CdrProblem {
    let mut record = Record::new(ty);
    let error = record.decode_cdr(payload).unwrap_err();
    assert_eq!(record.to_json(), Record::new(ty).to_json(), "a refused message leaves nothing");
    error.problem
}

fn alone(build: impl FnOnce(&mut TypeTable) -> TypeId) -> DataType {
    let mut t = TypeTable::default();
    let id = build(&mut t);
    DataType::new(&Arc::new(t), id).unwrap()
}

#[test]
fn lengths_beyond_the_message_allocate_nothing() {
    let ty = alone(|t| {
        let element = t.add(Kind::Double);
        t.add(Kind::Sequence { element, bound: None })
    });
    let huge = u32::MAX.to_le_bytes();
    assert_eq!(problem(&ty, &huge), CdrProblem::Length { length: u32::MAX as usize, most: 0 });
    // Small on the wire, large in memory: 4 bytes stand for 8 KB.
    let ty = alone(|t| {
        let element = t.add(Kind::Double);
        let element = t.add(Kind::Sequence { element, bound: Some(1000) });
        t.add(Kind::Sequence { element, bound: None })
    });
    let mut bomb = 1_000_000u32.to_le_bytes().to_vec();
    bomb.resize(4_000_004, 0);
    assert_eq!(problem(&ty, &bomb), CdrProblem::Memory);
}

#[test]
fn strings_need_their_nul_and_utf8() {
    let ty = alone(|t| t.add(Kind::String { bound: Some(4) }));
    assert_eq!(problem(&ty, b"\x02\0\0\0ab"), CdrProblem::Nul);
    assert_eq!(problem(&ty, b"\x03\0\0\0\0b\0"), CdrProblem::Nul);
    assert_eq!(problem(&ty, b"\x02\0\0\0\xff\0"), CdrProblem::Utf8);
    assert_eq!(problem(&ty, b"\x05\0\0\0abcd\0"), CdrProblem::Length { length: 4, most: 3 });
    assert_eq!(problem(&ty, b"\x05\0\0\0abc\0"), CdrProblem::Truncated { needed: 5, left: 4 });
    let mut record = Record::new(&ty);
    record.decode_cdr(b"\x04\0\0\0abc\0").unwrap();
    assert_eq!(record.to_json(), json!("abc"));
    record.decode_cdr(b"\0\0\0\0").unwrap();
    assert_eq!(record.to_json(), json!(""));
}

#[test]
fn a_full_bounded_string_without_nul_is_read_to_its_end() {
    let ty = alone(|t| t.add(Kind::String { bound: Some(4) }));
    let mut record = Record::new(&ty);
    record.set_bytes(b"ab\xc3\xa9").unwrap();
    assert_eq!(record.to_json(), json!("abé"));
    // One byte less than the array is encoded, and no half character.
    let mut payload = Vec::new();
    record.encode_cdr(&mut payload).unwrap();
    assert_eq!(payload, b"\x03\0\0\0ab\0");
}

#[test]
fn other_representations_are_refused() {
    let mut record = Record::new(&reading());
    let error = record.decode_message(&[0, 3, 0, 0, 1]).unwrap_err();
    assert_eq!(error.problem, CdrProblem::Representation(3));
    assert!(record.decode_message(&[0, 1]).is_err());
}

#[test]
fn values_that_have_no_cdr_leave_the_buffer_alone() {
    let ty = alone(|t| {
        t.add(Kind::Enum { name: ScopedName::new(["e"]), enumerators: vec!["A".to_owned()] })
    });
    let mut record = Record::new(&ty);
    // SAFETY: an enum is an `uint32_t`.
    unsafe { record.as_mut_ptr().cast::<u32>().write(1) };
    let mut out = vec![1, 2, 3];
    let error = record.encode_message(&mut out).unwrap_err();
    assert_eq!(error.problem, CdrProblem::Enumerator { value: 1, count: 1 });
    assert_eq!((out, record.to_json()), (vec![1, 2, 3], json!("<invalid>")));
}

#[test]
fn nesting_without_end_is_refused() {
    let ty = alone(|t| {
        let own = t.add(Kind::Forward { name: ScopedName::new(["s"]), union: false });
        let kids = t.add(Kind::Sequence { element: own, bound: None });
        let members = vec![Member { name: "kids".to_owned(), ty: kids }];
        t.complete(own, Kind::Struct { name: ScopedName::new(["s"]), members });
        own
    });
    let one = 1u32.to_le_bytes();
    let deep = one.repeat(100_000);
    assert!(matches!(problem(&ty, &deep), CdrProblem::Deep(_)));
    let mut some = one.repeat(20);
    some.extend([0; 4]);
    let mut record = Record::new(&ty);
    record.decode_cdr(&some).unwrap();
    let (copy, mut again) = (record.clone(), Vec::new());
    drop(record);
    copy.encode_cdr(&mut again).unwrap();
    assert_eq!(again, some);
}

#[test]
fn values_may_stand_after_others_in_a_payload() {
    let ty = reading();
    let mut record = Record::new(&ty);
    record
        .merge_json(&json!({"ok": true, "name": "arm", "stamp": -5, "notes": ["a", "bc"]}))
        .unwrap();
    let mut alone = Vec::new();
    record.encode_cdr(&mut alone).unwrap();
    for before in 0..17 {
        // Other data, then a payload that begins with other data.
        let mut out = vec![0xaa; 3];
        out.extend(vec![0xbb; before]);
        record.encode_cdr_within(3, &mut out).unwrap();
        let mut back = Record::new(&ty);
        back.decode_cdr_within(&out[3..], before, false).unwrap();
        assert_eq!(back.to_json(), record.to_json(), "after {before} bytes");
        if before % 8 == 0 {
            assert_eq!(out[3 + before..], alone[..], "aligned alike");
        }
    }
    assert!(Record::new(&ty).decode_cdr_within(&alone, alone.len() + 9, false).is_err());
}

#[test]
fn a_message_is_not_written_beyond_the_room_it_is_given() {
    let mut record = Record::new(&reading());
    record.merge_json(&json!({"name": "front", "notes": ["a", "b"], "raw": [1, 2, 3]})).unwrap();
    let whole = record.message_size() + genom_types::cdr::SLACK;
    for room in 0..whole {
        let mut memory = vec![std::mem::MaybeUninit::new(0xaau8); whole];
        let written = record.encode_message_to(&mut memory[..room]);
        // Where less than the slack is missing, it may still fit; where more is, it never does.
        assert!(written.is_err() || room >= record.message_size(), "{room} of {whole}");
        // SAFETY: all bytes were written when it was made.
        let beyond = memory[room..].iter().map(|byte| unsafe { byte.assume_init() });
        assert!(beyond.into_iter().all(|byte| byte == 0xaa), "{room} of {whole}");
    }
}
