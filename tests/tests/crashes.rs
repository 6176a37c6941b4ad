//! A daemon that is killed wherever it stands leaves nothing that its successor or its peers
//! would notice. `crashes` (a program of this crate) takes every call; here some of each phase.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use std::path::Path;
use std::thread;

use genom_tests::crash::{Phase, Plan, Stage};

/// Points taken of each phase, spread over all its calls.
const POINTS: usize = 3;

/// Ends daemons in this phase, and after its last call.
fn survives(phase: Phase) {
    let mut stage = Stage::new(Path::new(env!("CARGO_BIN_EXE_crashes")));
    let calls = stage.calls(phase);
    // One of the calls between which a file is there and not finished, and others.
    let unfinished = calls.iter().position(|step| step.call == "fchmod").unwrap_or_default();
    let spread = (1..POINTS).map(|point| point * calls.len() / POINTS);
    let points: Vec<usize> = [unfinished].into_iter().chain(spread).chain([calls.len()]).collect();
    for (rank, call) in points.into_iter().enumerate() {
        let outcome = stage.run(Plan { phase, call, followed: rank % 2 == 1 });
        assert!(outcome.is_fine(), "{outcome}");
    }
    let left = stage.end();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_daemon_killed_at_any_call_leaves_nothing_in_the_way_of_successor_and_peers() {
    // Side by side: each has shared memory of its own.
    thread::scope(|scope| {
        for phase in Phase::ALL {
            scope.spawn(move || survives(phase));
        }
    });
}

#[test]
fn a_daemon_that_is_watched_goes_through_every_phase_with_calls_on_shared_memory() {
    let stage = Stage::new(Path::new(env!("CARGO_BIN_EXE_crashes")));
    for phase in Phase::ALL {
        let calls = stage.calls(phase);
        let makes_or_removes = calls.iter().any(|step| ["openat", "unlink"].contains(&step.call));
        assert!(calls.len() > 30 && makes_or_removes, "{phase:?}: {calls:?}");
    }
    let load = stage.calls(Phase::Load);
    for call in ["openat", "ftruncate", "fchmod", "mmap", "close", "fcntl", "write"] {
        assert!(load.iter().any(|step| step.call == call), "{call}");
    }
    assert!(stage.end().is_empty());
}
