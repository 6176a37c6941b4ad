//! Latency of a hop from a writer in one process to a reader in another: of the bare middleware,
//! and of a port of genomd.
//!
//! `cargo bench -p genom-bench --bench hop [-- BACKEND...] [--period MICROSECONDS] [--rounds N]`
//! `[--gateway]`: zenoh and ros2 through a gateway on each side.
//!
//! "Bare" uses the middleware's own interface and copies bytes in and out. "Port" is what a codel's
//! `write()` and `read()` do: the backend's publisher and subscription, opened as the daemon opens
//! them, for an octet array (fixed size) and an octet sequence (variable size). Readers poll, so
//! that the time to wake a reader is included in neither.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that prints figures")]

mod gateway;
mod place;
mod ports;
mod ros2;
mod shm;
mod zenoh;

use std::error::Error;
use std::path::Path;

use genom_bench::pair::{Reader, Receive, Send, serve};
use genom_bench::{Figures, SIZES};
use genom_middleware::Middleware;

/// One middleware, bare and as genomd's backend, in one process.
trait Backend {
    /// The writing end of the bare middleware.
    fn writer(&self, bytes: usize) -> Box<dyn Send>;
    /// The reading end of the bare middleware.
    fn reader(&self, bytes: usize) -> Box<dyn Receive>;
    /// The same middleware as genomd's backend.
    fn ours(&self) -> &dyn Middleware;
}

const BACKENDS: [&str; 3] = ["shm", "zenoh", "ros2"];

/// Precedes the folder that both processes share, in the arguments of the reading process.
const READER: &str = "--reader";

/// Given to the reading process, too.
const THROUGH: &str = "--gateway";

fn open(name: &str, place: &Path, reads: bool, through: bool) -> Box<dyn Backend> {
    let (name, both): (_, Box<dyn Backend>) = match name {
        "shm" => return Box::new(shm::Both::open(place)),
        "zenoh" => ("zenoh", Box::new(zenoh::Both::open(place, reads))),
        _ => ("ros2", Box::new(ros2::Both::open())),
    };
    if through { Box::new(gateway::Through::open(name, place, reads, both)) } else { both }
}

fn read(name: &str, place: &Path, through: bool) -> Result<(), Box<dyn Error>> {
    let backend = open(name, place, true, through);
    serve(|bytes| {
        let [array, sequence] = ports::readers(backend.ours(), bytes);
        vec![backend.reader(bytes), array, sequence]
    })?;
    Ok(())
}

fn measure(name: &str, rounds: usize, period: u64, through: bool) -> Result<(), Box<dyn Error>> {
    let place = tempfile::tempdir()?;
    let backend = open(name, place.path(), false, through);
    let at = place.path().display().to_string();
    let way = if through { THROUGH } else { "" };
    let mut reader = Reader::start(&[READER, name, &at, way])?;
    for bytes in SIZES {
        reader.open(bytes)?;
        let [array, sequence] = ports::writers(backend.ours(), bytes);
        let mut ends = [backend.writer(bytes), array, sequence];
        let figures = reader.measure(&mut ends, rounds, period)?;
        let [bare, array, sequence] = figures[..] else { return Err("three ways".into()) };
        let more = |ours: Figures| {
            format!("{:+.1} {:>5.2}x", (ours.p50 - bare.p50) / 1000.0, ours.p50 / bare.p50)
        };
        println!(
            "{name:>6} {bytes:>8} {bare:>20} {array:>20} {:>13} {sequence:>20} {:>13}",
            more(array),
            more(sequence),
        );
    }
    drop(backend);
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
        "{:>6} {:>8} {:>20} {:>20} {:>13} {:>20} {:>13}",
        "", "bytes", "bare", "port, array", "+us      x", "port, sequence", "+us      x"
    );
    for name in BACKENDS.iter().filter(wanted) {
        measure(name, usize::try_from(rounds)?, period, through)?;
    }
    Ok(())
}
