//! Latency of a hop from a writer in one process to a reader in another: of the bare middleware,
//! and of a port of genomd.
//!
//! `cargo bench -p genom-bench --bench hop [-- BACKEND...] [--period MICROSECONDS] [--rounds N]`
//! `[--gateway]`: all but shm through a gateway on each side. `rmw_zenoh` is ROS 2 over zenoh.
//!
//! "Bare" uses the middleware's own interface and copies bytes in and out. "Port" is what a codel's
//! `write()` and `read()` do: the backend's publisher and subscription, opened as the daemon opens
//! them, for an octet array (fixed size) and an octet sequence (variable size). Readers poll, so
//! that the time to wake a reader is included in neither.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that prints figures")]

mod ends;
mod gateway;
mod ours;
mod ports;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use genom_bench::bare::{self, Bare};
use genom_bench::pair::{Reader, serve};
use genom_bench::{Figures, SIZES};
use genom_middleware::Middleware;

/// One middleware, bare and as genomd's backend, in one process.
struct Both {
    bare: Box<dyn Bare>,
    ours: Ours,
}

/// genomd's backend.
enum Ours {
    Direct(Arc<dyn Middleware>),
    Through(gateway::Through),
}

impl Both {
    fn ours(&self) -> &dyn Middleware {
        match &self.ours {
            Ours::Direct(middleware) => &**middleware,
            Ours::Through(gateway) => gateway.ours(),
        }
    }
}

const BACKENDS: [&str; 4] = ["shm", "zenoh", "ros2", ours::RMW_ZENOH];

/// Precedes the folder that both processes share, in the arguments of the reading process.
const READER: &str = "--reader";

/// Given to the reading process, too.
const THROUGH: &str = "--gateway";

fn open(name: &str, place: &Path, reads: bool, through: bool) -> Result<Both, Box<dyn Error>> {
    let name = BACKENDS.into_iter().find(|known| *known == name).ok_or("no such backend")?;
    let carries = if name == ours::RMW_ZENOH { "zenoh" } else { name };
    let bare = bare::open(carries, place, reads)?.ok_or("no such middleware")?;
    let ours = match through && name != "shm" {
        true => Ours::Through(gateway::Through::open(name, place, reads)),
        false => Ours::Direct(ours::open(name, place, reads)),
    };
    Ok(Both { bare, ours })
}

fn read(name: &str, place: &Path, through: bool) -> Result<(), Box<dyn Error>> {
    let both = open(name, place, true, through)?;
    serve(|bytes| {
        let [array, sequence] = ports::readers(both.ours(), bytes);
        Ok(vec![both.bare.reader(bytes)?, array, sequence])
    })?;
    Ok(())
}

fn measure(name: &str, rounds: usize, period: u64, through: bool) -> Result<(), Box<dyn Error>> {
    let place = tempfile::tempdir()?;
    let both = open(name, place.path(), false, through)?;
    let at = place.path().display().to_string();
    let way = if through { THROUGH } else { "" };
    let mut reader = Reader::start(&[READER, name, &at, way])?;
    for bytes in SIZES {
        reader.open(bytes)?;
        let [array, sequence] = ports::writers(both.ours(), bytes);
        let mut ends = [both.bare.writer(bytes)?, array, sequence];
        let measured = reader.measure(&mut ends, rounds, period, || true)?;
        let figures: Vec<_> =
            measured.into_iter().filter_map(|one| Figures::of(one.durations)).collect();
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
    drop(both);
    reader.finish()?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo bench` adds `--bench`.
    let arguments: Vec<_> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let [READER, name, place, way] = words[..] {
        return read(name, Path::new(place), way == THROUGH);
    }
    if let [gateway::GATEWAY, name, place, side] = words[..] {
        return gateway::serve(name, Path::new(place), Path::new(side));
    }
    let through = words.contains(&THROUGH);
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
        measure(name, usize::try_from(rounds)?, period, through)?;
    }
    Ok(())
}
