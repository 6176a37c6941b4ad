//! Latency of a value from a writer to a reader within one process.
//!
//! `cargo bench -p genom-bench --bench exchange`

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a program that prints figures"
)]

use std::hint::black_box;
use std::time::Instant;

use genom_bench::{SIZES, octets};
use genom_local::Local;
use genom_middleware::{Address, Policy, PortSpec, Ports};

const ROUNDS: usize = 200_000;

fn per_round(rounds: usize, mut round: impl FnMut()) -> f64 {
    (0..rounds / 10).for_each(|_| round());
    let start = Instant::now();
    (0..rounds).for_each(|_| round());
    start.elapsed().as_nanos() as f64 / rounds as f64
}

fn main() {
    println!(
        "{:>9} {:>12} {:>12} {:>12} {:>12}",
        "bytes", "memcpy x2", "latest", "ring", "8 readers"
    );
    for length in SIZES {
        let (sent, mut got) = (octets::array(length), octets::array(length));
        let ty = sent.ty();
        let rounds = (ROUNDS * 64 / length).max(200);
        let (mut between, mut last) = (vec![0; length], vec![0; length]);
        let bare = per_round(rounds, || {
            between.copy_from_slice(black_box(sent.bytes().unwrap_or_default()));
            last.copy_from_slice(black_box(&between));
            black_box(&mut last);
        });
        let mut hop = |policy: Policy, readers: usize| {
            let local = Local::new();
            let at = Address::new("bench", "port");
            let mut writer = local.publisher(&PortSpec::new(&at, ty)).expect("an out port");
            let mut readers: Vec<_> = (0..readers)
                .filter_map(|_| local.subscription(&PortSpec::new(&at, ty), policy).ok())
                .collect();
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
