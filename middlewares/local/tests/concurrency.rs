//! Readers are opened and closed while a writer writes values that own heap memory.
//!
//! Nothing but the exchange synchronises them, so that ThreadSanitizer and Miri can check it
//! (`docs/proofs.md`).

#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicBool, Ordering};

use genom_conformance::samples::note;
use genom_local::Local;
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_types::Record;
use serde_json::{Value, json};

/// Number of samples; Miri is a thousand or more times slower.
const LAST: u64 = if cfg!(miri) { 10 } else { 20_000 };

/// A value with many allocations, each of which encodes `n`.
fn value(n: u64) -> Value {
    let row = vec![n & 0xffff; (n % 5) as usize];
    json!({ "text": format!("sample {n}"), "rows": [row, row] })
}

/// The number that a value encodes. Fails if its parts disagree.
fn number(record: &Record) -> u64 {
    let found = record.to_json();
    let text = found["text"].as_str().unwrap();
    let n = text.strip_prefix("sample ").unwrap().parse().unwrap();
    assert_eq!(found, value(n), "the sample is torn");
    n
}

#[test]
fn readers_that_come_and_go_see_whole_values_in_order() {
    let local = Local::new();
    let at = Address::new("demo", "notes");
    let mut writer = local.publisher(&PortSpec::new(&at, &note())).unwrap();
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for policy in [Policy::Latest, Policy::Queue(3), Policy::Ring(3)] {
            let (local, at, ended) = (&local, &at, &ended);
            scope.spawn(move || {
                let mut record = Record::new(&note());
                let mut newest = 0;
                while !ended.load(Ordering::Acquire) {
                    let mut reader =
                        local.subscription(&PortSpec::new(at, &note()), policy).unwrap();
                    let mut previous = 0;
                    for _ in 0..8 {
                        if reader.read(&mut record).unwrap() == Reading::New {
                            let n = number(&record);
                            assert!(n > previous, "{n} after {previous}");
                            previous = n;
                        }
                    }
                    newest = newest.max(previous);
                    std::thread::yield_now();
                }
                // A reader that is opened after the last sample gets it.
                let mut reader = local.subscription(&PortSpec::new(at, &note()), policy).unwrap();
                assert_eq!(reader.read(&mut record), Ok(Reading::New));
                assert!(number(&record) == LAST && newest <= LAST);
            });
        }
        let mut record = Record::new(&note());
        for n in 1..=LAST {
            record.merge_json(&value(n)).unwrap();
            writer.publish(&record).unwrap();
        }
        ended.store(true, Ordering::Release);
    });
    drop(writer);
}
