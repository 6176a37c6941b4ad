//! Ways of ending daemons while they use shared memory. The effects are part of `cargo faults`
//! (`trials.rs`).

use std::path::Path;

use genom_tests::crash::{Phase, Stage};

#[test]
fn a_daemon_that_is_watched_goes_through_every_phase_with_calls_on_shared_memory() {
    let stage = Stage::new(Path::new(env!("CARGO_BIN_EXE_faults")));
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
