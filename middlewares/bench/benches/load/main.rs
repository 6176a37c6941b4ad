//! What a middleware carries from one process to another: images of a camera, many topics at once,
//! and calls of a service.
//!
//! `cargo bench -p genom-bench --bench load [-- BACKEND...] [--seconds N]`
//!
//! Samples are sent at the rate that the table names, for 10 s unless told otherwise, and counted
//! where they arrive: those of the bare middleware, then those of ports as codels write and read
//! them; images also between ports and a node of ROS 2 with Fast DDS. Calls are made one after the other, at most 1,000 a second; the bare middlewares have none
//! to compare with. "Processor" is the time of both processes beside the time that passed.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that prints figures")]

mod calls;
#[path = "../hop/ends.rs"]
mod ends;
mod foreign;
#[path = "../hop/ours.rs"]
mod ours;
mod reading;
mod usage;
mod writing;

use std::error::Error;
use std::path::Path;

const BACKENDS: [&str; 5] = ["shm", "zenoh", "ros2", ours::RMW_ZENOH, foreign::NAME];

/// Precedes what the reading process is told.
const READER: &str = "--reader";

/// Samples that are sent for some time.
struct Flow {
    name: &'static str,
    topics: usize,
    bytes: usize,
    /// A second, on each topic.
    rate: u32,
}

const FLOWS: [Flow; 2] = [
    Flow { name: "images, 6 MB", topics: 1, bytes: 6_000_000, rate: 30 },
    Flow { name: "100 topics, 1 KiB", topics: 100, bytes: 1024, rate: 100 },
];

/// How samples go.
#[derive(Clone, Copy)]
enum Way {
    Bare,
    Ports,
}

impl Way {
    fn word(self) -> &'static str {
        match self {
            Self::Bare => "bare",
            Self::Ports => "ports",
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo bench` adds `--bench`.
    let arguments: Vec<_> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let [READER, name, place, what] = words[..] {
        return reading::serve(name, Path::new(place), what);
    }
    let seconds = words.iter().position(|word| *word == "--seconds");
    let seconds = seconds.map_or(Ok(10), |at| words.get(at + 1).unwrap_or(&"").parse())?;
    let wanted =
        |name: &&&str| words.contains(*name) || !words.iter().any(|word| BACKENDS.contains(word));
    println!(
        "{:>9} {:>18} {:>6} {:>8} {:>8} {:>9} {:>9}",
        "", "", "", "sent", "arrived", "a second", "processor"
    );
    for name in BACKENDS.iter().filter(wanted) {
        if *name == foreign::NAME {
            foreign::measure(seconds)?;
            continue;
        }
        for flow in &FLOWS {
            for way in [Way::Bare, Way::Ports] {
                writing::flow(name, flow, way, seconds)?;
            }
        }
        calls::measure(name, seconds)?;
    }
    Ok(())
}
