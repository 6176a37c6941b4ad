//! How long a value takes from a writer to a reader within one process.
//!
//! `cargo bench -p genom-local`

#![allow(clippy::expect_used, clippy::print_stdout, reason = "a program that prints figures")]

use std::hint::black_box;
use std::time::Instant;

use genom_local::Local;
use genom_middleware::{Address, Middleware, Policy};
use genom_types::{DataType, Kind, Record, TypeTable};

const ROUNDS: u32 = 200_000;

/// An array of that many octets.
fn octets(length: u32) -> DataType {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(Kind::Array { element, length });
    DataType::new(&table.into(), id).expect("a type that can be laid out")
}

fn per_round(rounds: u32, mut round: impl FnMut()) -> f64 {
    (0..rounds / 10).for_each(|_| round());
    let start = Instant::now();
    (0..rounds).for_each(|_| round());
    start.elapsed().as_nanos() as f64 / f64::from(rounds)
}

fn main() {
    println!(
        "{:>9} {:>12} {:>12} {:>12} {:>12}",
        "bytes", "memcpy x2", "latest", "ring", "8 readers"
    );
    for length in [64, 4 << 10, 64 << 10, 1 << 20] {
        let ty = octets(length);
        let rounds = (ROUNDS * 64 / length).max(200);
        let (sent, mut got) = (Record::new(&ty), Record::new(&ty));
        let mut between = vec![0; length as usize];
        let mut last = vec![0; length as usize];
        let bare = per_round(rounds, || {
            between.copy_from_slice(black_box(sent.bytes().unwrap_or_default()));
            last.copy_from_slice(black_box(&between));
            black_box(&mut last);
        });
        let mut hop = |policy: Policy, readers: usize| {
            let local = Local::new();
            let at = Address::new("bench", "port");
            let mut writer = local.publisher(&at, &ty).expect("an out port");
            let mut readers: Vec<_> =
                (0..readers).filter_map(|_| local.subscription(&at, &ty, policy).ok()).collect();
            per_round(rounds, || {
                let _ = writer.publish(black_box(&sent));
                for reader in &mut readers {
                    let _ = black_box(reader.read(&mut got));
                }
            })
        };
        println!(
            "{length:>9} {bare:>9.0} ns {:>9.0} ns {:>9.0} ns {:>9.0} ns",
            hop(Policy::Latest, 1),
            hop(Policy::Ring(4), 1),
            hop(Policy::Latest, 8),
        );
    }
}
