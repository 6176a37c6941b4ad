//! Latency of a hop from a writer in one process to a reader in another: of the bare middleware,
//! and of a port of genomd.
//!
//! `cargo bench -p genom-bench --bench hop [-- BACKEND...] [--period MICROSECONDS] [--rounds N]`
//! `[--gateway]`: all but shm through a gateway on each side. `rmw_zenoh` is ROS 2 over zenoh.
//!
//! "Bare" uses the middleware's own interface and copies bytes in and out. "Port" is what a codel's
//! `write()` and `read()` do: the backend's publisher and subscription, opened as the daemon opens
//! them, for an octet array (fixed size) and an octet sequence (variable size). Each of the two has
//! a writing and a reading process of its own, which take turns. Readers poll, so that the time to
//! wake a reader is included in neither.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that prints figures")]

mod ends;
mod gateway;
mod ours;
mod ports;
mod side;

use std::error::Error;
use std::path::Path;

use genom_bench::{Figures, SIZES};

use crate::side::{Side, Way};

const BACKENDS: [&str; 4] = ["shm", "zenoh", "ros2", ours::RMW_ZENOH];

/// Ports through gateways.
const THROUGH: &str = "--gateway";

fn measure(name: &str, rounds: usize, period: u64, ours: Way) -> Result<(), Box<dyn Error>> {
    let place = tempfile::tempdir()?;
    let start = |way| Side::start(name, way, place.path(), period);
    let mut sides = [start(Way::Bare)?, start(ours)?];
    for bytes in SIZES {
        for side in &mut sides {
            side.open(bytes, rounds)?;
        }
        let [bare, ours] = loop {
            if let [Some(bare), Some(ours)] = [sides[0].round()?, sides[1].round()?] {
                break [bare, ours];
            }
        };
        let figures: Vec<_> = bare.into_iter().chain(ours).filter_map(Figures::of).collect();
        let [bare, array, sequence] = figures[..] else { return Err("three ways".into()) };
        let more = |ours: Figures| {
            format!("{:+.1} {:>5.2}x", (ours.p50 - bare.p50) / 1000.0, ours.p50 / bare.p50)
        };
        println!(
            "{name:>9} {bytes:>8} {bare:>20} {array:>20} {:>13} {sequence:>20} {:>13}",
            more(array),
            more(sequence),
        );
    }
    sides.into_iter().try_for_each(Side::finish)
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo bench` adds `--bench`.
    let arguments: Vec<_> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let way = |word| Way::of(word).ok_or("no such way");
    match words[..] {
        [side::WRITES, name, word, place, period] => {
            return side::write(name, way(word)?, Path::new(place), period.parse()?);
        }
        [side::READS, name, word, place] => return side::read(name, way(word)?, Path::new(place)),
        [gateway::GATEWAY, name, place, side] => {
            return gateway::serve(name, Path::new(place), Path::new(side));
        }
        _ => {}
    }
    let ours = if words.contains(&THROUGH) { Way::Gateways } else { Way::Ports };
    let number = |key: &str, default: u64| {
        let place = words.iter().position(|word| *word == key);
        place.map_or(Ok(default), |at| words.get(at + 1).unwrap_or(&"").parse())
    };
    let (period, rounds) = (number("--period", 1000)? * 1000, number("--rounds", 500)?);
    let wanted =
        |name: &&&str| words.contains(*name) || !words.iter().any(|word| BACKENDS.contains(word));
    println!("one hop in us, p50 / p99; a value every {} us", period / 1000);
    println!(
        "{:>9} {:>8} {:>20} {:>20} {:>13} {:>20} {:>13}",
        "", "bytes", "bare", "port, array", "+us      x", "port, sequence", "+us      x"
    );
    for name in BACKENDS.iter().filter(wanted) {
        measure(name, usize::try_from(rounds)?, period, ours)?;
    }
    Ok(())
}
