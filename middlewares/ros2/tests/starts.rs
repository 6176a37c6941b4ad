//! Two processes that meet for the first time, again and again: from then on samples flow.

#![allow(clippy::unwrap_used, reason = "test code, also outside of test functions")]

mod world;

use std::io::Read as _;
use std::process::{Command, Stdio};
use std::thread;

use genom_middleware::conformance::eventually;
use genom_middleware::conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Middleware, Policy, Reading};
use genom_ros2::ServiceMapping;
use world::Domain;

/// Starts, in all.
const STARTS: u64 = 100;
/// Side by side, each in a domain of its own.
const SIDES: u64 = 4;
/// Samples that are read.
const SAMPLES: u64 = 200;

/// What came of the samples from the first to the last one that was read.
#[derive(Debug)]
struct Flow {
    seen: u64,
    /// On the way, counted by the reader.
    lost: u64,
    /// These, and those that newer ones overtook before they left.
    written: u64,
}

/// One process writes a sample every millisecond; this one reads them.
fn flow(domain: &Domain, reader_first: bool) -> Flow {
    let at = Address::new("demo", "position");
    let open = || {
        let ros2 = domain.open();
        ros2.subscription(&at, &state(), Policy::Ring(1024)).unwrap()
    };
    let early = reader_first.then(open);
    let mut writer = Command::new(env!("CARGO_BIN_EXE_ros2-writer"))
        .args([&domain.options().domain.to_string(), "flow"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut reader = early.unwrap_or_else(open);
    let mut got = numbered(0);
    let (mut first, mut last, mut seen) = (None, 0, 0);
    eventually("samples flow", || {
        while reader.read(&mut got).unwrap() == Reading::New {
            last = number(&got);
            first.get_or_insert(last);
            seen += 1;
        }
        seen >= SAMPLES
    });
    let lost = reader.dropped();
    drop(writer.stdin.take());
    let mut told = String::new();
    writer.stdout.take().unwrap().read_to_string(&mut told).unwrap();
    assert!(writer.wait().unwrap().success());
    Flow { seen, lost, written: last + 1 - first.unwrap() }
}

#[test]
fn samples_flow_after_each_of_many_first_meetings_of_two_processes() {
    let flows: Vec<Flow> = thread::scope(|scope| {
        let sides: Vec<_> = (0..SIDES)
            .map(|side| {
                scope.spawn(move || {
                    let domain = Domain::new(ServiceMapping::Enhanced);
                    let starts = (0..STARTS / SIDES).map(|start| (start + side) % 2 == 0);
                    starts.map(|reader_first| flow(&domain, reader_first)).collect::<Vec<_>>()
                })
            })
            .collect();
        sides.into_iter().flat_map(|side| side.join().unwrap()).collect()
    });
    assert_eq!(flows.len() as u64, STARTS);
    for flow in &flows {
        assert!(flow.seen + flow.lost <= flow.written, "{flow:?}");
    }
    let sum = |count: fn(&Flow) -> u64| flows.iter().map(count).sum::<u64>();
    let (seen, sent) = (sum(|flow| flow.seen), sum(|flow| flow.seen + flow.lost));
    // All but a few; half of them where other tests take the processors.
    assert!(2 * seen > sent, "{seen} of {sent} arrived: {flows:?}");
}
