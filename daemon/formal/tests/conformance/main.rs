//! The rules of the model are those of the runtime: random runs of it, with random components, are
//! accepted step by step, and refused as soon as one rule of the model is changed.
//!
//! `cargo bench --workspace --bench conformance -- 10000` does the same, and counts what was seen.

#![allow(clippy::unwrap_used, clippy::panic)]

mod accept;
mod body;
mod components;
mod exclusion;
mod play;
mod random;

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use accept::accept;
use genom_formal::Variant;
use play::play;

/// Runs that have to be accepted, by as many threads as there are processors.
const RUNS: u64 = 10_000;
/// Runs of which a model with a changed rule has to refuse one.
const FEW: u64 = 300;

#[test]
fn random_runs_of_the_runtime_are_accepted_step_by_step() {
    let (next, threads) = (AtomicU64::new(0), thread::available_parallelism());
    thread::scope(|scope| {
        for _ in 0..threads.map_or(1, NonZeroUsize::get) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= RUNS {
                        break;
                    }
                    is_accepted(seed);
                }
            });
        }
    });
}

fn is_accepted(seed: u64) {
    let played = play(seed);
    if let Err(refused) = accept(&played.system(None), &played.log) {
        let seen = &played.log[..=refused.0];
        panic!("seed {seed}: the last is refused\n{}\n{}", played.text, lines(seen));
    }
}

fn lines(seen: &[body::Seen]) -> String {
    seen.iter().map(|seen| format!("{seen:?}\n")).collect()
}

/// Whether a system with a changed rule refuses one of the runs.
fn refuses(variant: Variant) -> bool {
    (0..FEW).any(|seed| {
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
