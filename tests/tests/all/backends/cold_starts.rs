//! Pairs of daemons that meet over ROS 2 for the first time, many times: samples flow each time.

use std::sync::Arc;
use std::thread;

use genom_tests::{Daemon, Home, Memory, component, path, request, until};

/// Number of starts.
const STARTS: usize = 100;
/// Number of starts in parallel.
const SIDES: usize = 4;
/// Number of samples read in each.
const SAMPLES: u64 = 200;

/// Starts a component on ROS 2 whose task ticks every millisecond.
fn start(memory: &Arc<Memory>, name: &str, task: &str) -> Daemon {
    let library = component(name).library;
    let text = format!(
        "backend = \"ros2\"\n[[component]]\nlibrary = {:?}\n[component.tasks.{task}]\n\
         period_ms = 1.0\n",
        path(&library)
    );
    Home::with(memory).configured(&text).start(&[])
}

/// The mission writes a gain in each tick, and the demo reads it. Returns how many were read and
/// how many were lost.
fn flow(reader_first: bool) -> (u64, u64) {
    let memory = Arc::new(Memory::new());
    let write = || start(&memory, "mission", "watch");
    let read = || start(&memory, "demo", "main");
    let (_writer, reader) = if reader_first {
        let reader = read();
        (write(), reader)
    } else {
        (write(), read())
    };
    let connect = ["connect", "--wait", "demo/parameter", "mission/gain", "--policy", "ring:64"];
    reader.ctl(&connect).expect_code(0);
    // The demo reads its port while it moves.
    reader.ctl(&["call", "demo", "set_speed", "velocity=0.0001"]).expect_code(0);
    reader.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let counted = || {
        let at = "/components/demo/ports/parameter/traffic";
        let counts = request(&reader.home().socket(), "GET", at, "").body;
        ["samples", "dropped"].map(|name| counts[name].as_u64().unwrap())
    };
    until("samples flow", || counted()[0] >= SAMPLES);
    let [seen, lost] = counted();
    (seen, lost)
}

#[test]
fn samples_flow_after_each_of_many_first_meetings_of_two_daemons() {
    let counts: Vec<(u64, u64)> = thread::scope(|scope| {
        let sides: Vec<_> = (0..SIDES)
            .map(|side| {
                scope.spawn(move || {
                    let starts = (0..STARTS / SIDES).map(|start| flow((start + side) % 2 == 0));
                    starts.collect::<Vec<_>>()
                })
            })
            .collect();
        sides.into_iter().flat_map(|side| side.join().unwrap()).collect()
    });
    assert_eq!(counts.len(), STARTS);
    let seen: u64 = counts.iter().map(|count| count.0).sum();
    let lost: u64 = counts.iter().map(|count| count.1).sum();
    // Usually almost all; half of them if other tests use the processors.
    assert!(seen > lost, "{seen} arrived, {lost} did not: {counts:?}");
}
