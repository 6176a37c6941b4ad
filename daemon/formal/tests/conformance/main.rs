//! The rules of the model are those of the runtime: random runs of it, with random components, are
//! accepted step by step, and refused as soon as one rule of the model is changed.
//!
//! `cargo bench --workspace --bench conformance -- 10000` does the same with more runs.

#![allow(clippy::unwrap_used, clippy::panic)]

mod accept;
mod body;
mod components;
mod exclusion;
mod play;
mod random;

use accept::accept;
use genom_formal::Variant;
use play::play;

/// Runs of these tests.
const RUNS: u64 = 300;

#[test]
fn random_runs_of_the_runtime_are_accepted_step_by_step() {
    for seed in 0..RUNS {
        let played = play(seed);
        if let Err(refused) = accept(&played.system(None), &played.log) {
            let seen = &played.log[..=refused.0];
            panic!("seed {seed}: the last is refused\n{}\n{}", played.text, lines(seen));
        }
    }
}

fn lines(seen: &[body::Seen]) -> String {
    seen.iter().map(|seen| format!("{seen:?}\n")).collect()
}

/// Whether a system with a changed rule refuses one of the runs.
fn refuses(variant: Variant) -> bool {
    (0..RUNS).any(|seed| {
        let played = play(seed);
        accept(&played.system(Some(variant)), &played.log).is_err()
    })
}

#[test]
fn a_model_that_stops_on_ticks_only_is_refused() {
    assert!(refuses(Variant::StopOnTicks));
}

#[test]
fn a_model_that_runs_activities_to_their_pauses_is_refused() {
    assert!(refuses(Variant::RunToPause));
}

#[test]
fn a_model_that_loses_wake_ups_is_refused() {
    assert!(refuses(Variant::LostWakeUp));
}

#[test]
fn a_model_without_phases_of_ticks_is_refused() {
    assert!(refuses(Variant::Phase));
}
