//! Random types and values survive JSON, CDR and copies unchanged, and random bytes do no harm.

#![allow(clippy::unwrap_used, clippy::panic)] // also in helpers, where clippy.toml does not reach

#[path = "support/oracle.rs"]
mod oracle;
mod support;

use std::mem::MaybeUninit;
use std::sync::Arc;

use genom_types::cdr::SLACK;
use genom_types::{DataType, Record, TypeTable};
use oracle::Oracle;
use proptest::prelude::*;
use serde_json::Value;
use support::{Rng, Types, value};

/// A type and a value of it.
fn sample(seed: u64, depth: u32, fixed: bool) -> (DataType, Value) {
    let (mut table, mut rng) = (TypeTable::default(), Rng::new(seed));
    let id = Types { table: &mut table, rng: &mut rng, fixed, count: 0 }.any(depth);
    let value = value(&table, id, &mut rng);
    (DataType::new(&Arc::new(table), id).unwrap(), value)
}

fn oracle(ty: &DataType, value: &Value, big_endian: bool) -> Vec<u8> {
    let mut oracle = Oracle { table: ty.table(), big_endian, out: Vec::new() };
    oracle.value(ty.id(), value);
    oracle.out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..Default::default() })]

    #[test]
    fn values_come_back_from_json_cdr_and_copies(seed: u64, depth in 0u32..5) {
        let (ty, json) = sample(seed, depth, false);
        let mut record = Record::new(&ty);
        record.merge_json(&json).unwrap();
        prop_assert_eq!(&record.to_json(), &json);

        let mut payload = Vec::new();
        record.encode_cdr(&mut payload).unwrap();
        prop_assert_eq!(&payload, &oracle(&ty, &json, false));

        // Into memory of the caller that is exactly as large as `message_size` says.
        let mut room = vec![MaybeUninit::new(0xaa); record.message_size() + SLACK];
        prop_assert_eq!(record.encode_message_to(&mut room).unwrap(), payload.len() + 4);
        // SAFETY: all bytes were written when it was made.
        let room: Vec<u8> = room.iter().map(|byte| unsafe { byte.assume_init() }).collect();
        prop_assert_eq!(&room[4..payload.len() + 4], &payload[..]);
        prop_assert_eq!(room.len(), payload.len() + 4 + SLACK);

        // Into a record with another value, so that leftovers would show.
        let mut other = Record::new(&ty);
        other.merge_json(&value(ty.table(), ty.id(), &mut Rng::new(!seed))).unwrap();
        other.decode_cdr(&payload).unwrap();
        prop_assert_eq!(&other.to_json(), &json);

        let mut message = vec![0, 0, 0, 0];
        message.extend(oracle(&ty, &json, true));
        other.decode_message(&message).unwrap();
        prop_assert_eq!(&other.to_json(), &json);

        // Who passes messages on finds what who reads them does.
        for message in [&message, &[&[0, 1, 0, 0], &payload[..]].concat()] {
            prop_assert_eq!(ty.check_message(message).unwrap(), message.len());
            let padded = [&message[..], &[7; 3]].concat();
            prop_assert_eq!(ty.check_message(&padded).unwrap(), message.len());
            let mut rng = Rng::new(seed ^ 11);
            for _ in 0..8 {
                let mut wrong = message.clone();
                let at = rng.below(wrong.len() as u64) as usize;
                wrong[at] = rng.next() as u8;
                wrong.truncate(wrong.len() - rng.below(3) as usize);
                let read = Record::new(&ty).decode_message(&wrong);
                prop_assert_eq!(ty.check_message(&wrong).map(drop), read);
            }
        }

        // Replaces another value, which stays when the message is cut.
        let old = value(ty.table(), ty.id(), &mut Rng::new(seed ^ 7));
        let (mut replaced, mut scratch) = (Record::new(&ty), Record::new(&ty));
        replaced.merge_json(&old).unwrap();
        let cut = message.len() - 1 - (seed % 3) as usize % (message.len() - 4).max(1);
        if replaced.replace_from_message(&message[..cut], &mut scratch).is_err() {
            prop_assert_eq!(&replaced.to_json(), &old);
        }
        replaced.replace_from_message(&message, &mut scratch).unwrap();
        prop_assert_eq!(&replaced.to_json(), &json);

        let mut copy = Record::new(&ty);
        copy.merge_json(&value(ty.table(), ty.id(), &mut Rng::new(seed ^ 5))).unwrap();
        copy.copy_from(&record).unwrap();
        drop(record);
        prop_assert_eq!(&copy.to_json(), &json);
        copy.clear();
        prop_assert_eq!(copy.to_json(), Record::new(&ty).to_json());
    }

    #[test]
    fn fixed_size_values_come_back_from_their_bytes(seed: u64, depth in 0u32..5) {
        let (ty, json) = sample(seed, depth, true);
        prop_assert!(ty.is_fixed_size());
        let (mut record, mut other) = (Record::new(&ty), Record::new(&ty));
        record.merge_json(&json).unwrap();
        other.set_bytes(record.bytes().unwrap()).unwrap();
        prop_assert_eq!(other.to_json(), json);
        // All bytes that were accepted can be shown and encoded.
        let mut noise = record.bytes().unwrap().to_vec();
        let mut rng = Rng::new(seed);
        for _ in 0..8.min(noise.len()) {
            let at = rng.below(noise.len() as u64) as usize;
            noise[at] = rng.next() as u8;
        }
        if other.set_bytes(&noise).is_ok() {
            let mut out = Vec::new();
            match other.encode_cdr(&mut out) {
                Ok(()) => other.decode_cdr(&out).unwrap(),
                Err(error) => prop_assert_eq!(error.problem, genom_types::CdrProblem::Utf8),
            }
        }
        _ = other.to_json();
    }

    #[test]
    fn damaged_messages_are_refused_or_are_values(seed: u64, depth in 0u32..5, damage in 0u64..4) {
        let (ty, json) = sample(seed, depth, false);
        let (mut message, mut rng) = (oracle(&ty, &json, false), Rng::new(seed ^ 77));
        let mut record = Record::new(&ty);
        match damage {
            0 if !message.is_empty() => {
                // A cut message is never accepted: no encoded value ends in padding.
                message.truncate(rng.below(message.len() as u64) as usize);
                prop_assert!(record.decode_cdr(&message).is_err());
            }
            1 => message = (0..rng.below(64)).map(|_| rng.next() as u8).collect(),
            _ if message.is_empty() => {}
            2 => for _ in 0..3 {
                let at = rng.below(message.len() as u64) as usize;
                message[at] = [0, 1, 0xff, rng.next() as u8][rng.below(4) as usize];
            },
            _ => {
                let at = rng.below(message.len() as u64) as usize;
                for byte in message.iter_mut().skip(at).take(4) {
                    *byte = 0xff;
                }
            }
        }
        if record.decode_cdr(&message).is_ok() {
            let mut again = Vec::new();
            record.encode_cdr(&mut again).unwrap();
            let shown = record.to_json();
            record.decode_cdr(&again).unwrap();
            prop_assert_eq!(record.to_json(), shown);
        } else {
            prop_assert_eq!(record.to_json(), Record::new(&ty).to_json());
        }
        let mut swapped = vec![0, 0, 0, 0];
        swapped.extend(&message);
        _ = record.decode_message(&swapped);
        _ = record.to_json();
    }

    #[test]
    fn random_json_is_refused_whole(seed: u64, depth in 0u32..5, other in 0u32..5) {
        let (ty, json) = sample(seed, depth, false);
        let (_, stranger) = sample(!seed, other, false);
        let mut record = Record::new(&ty);
        record.merge_json(&json).unwrap();
        if record.merge_json(&stranger).is_err() {
            prop_assert_eq!(record.to_json(), json);
        }
    }
}
