//! Random runs of the runtime, accepted by the model step by step:
//! `cargo bench --workspace --bench conformance -- 10000`.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[path = "../tests/conformance/accept.rs"]
mod accept;
#[path = "../tests/conformance/body.rs"]
mod body;
#[path = "../tests/conformance/components.rs"]
mod components;
#[path = "../tests/conformance/play.rs"]
mod play;
#[path = "../tests/conformance/random.rs"]
mod random;

use std::time::Instant;

use body::Seen;
use genom_formal::Variant;

fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|given| given.parse().ok()).collect();
    let (runs, first) = (numbers.first().unwrap_or(&1000), numbers.get(1).unwrap_or(&0));
    let begin = Instant::now();
    let (mut calls, mut seen, mut whole, mut wrong) = (0, 0, 0, Vec::new());
    // On a stepped clock nothing waits for a lock.
    let told = Variant::ALL.into_iter().filter(|variant| *variant != Variant::UnfairLock);
    let mut refused: Vec<(Variant, usize)> = told.map(|variant| (variant, 0)).collect();
    for seed in *first..*first + *runs {
        let played = play::play(seed);
        seen += played.log.len();
        calls += played.log.iter().filter(|seen| matches!(seen, Seen::Called { .. })).count();
        whole += usize::from(played.log.last() == Some(&Seen::Stopped));
        if let Err(refused) = accept::accept(&played.system(None), &played.log) {
            println!("seed {seed}: the last is refused\n{}", played.text);
            played.log[..=refused.0].iter().for_each(|seen| println!("{seen:?}"));
            wrong.push(seed);
        }
        // Changed models are the more expensive part: they get every tenth run.
        for (variant, count) in refused.iter_mut().filter(|_| seed % 10 == 0) {
            let system = played.system(Some(*variant));
            *count += usize::from(accept::accept(&system, &played.log).is_err());
        }
    }
    println!("{runs} runs, {calls} calls of codels, {seen} observations, {:.1?}", begin.elapsed());
    println!("with the whole shutdown: {whole}");
    println!("refused by the model: {} {wrong:?}", wrong.len());
    for (variant, count) in refused {
        println!("refused by the model with {variant:?}: {count} of {}", runs.div_ceil(10));
    }
    assert!(wrong.is_empty());
}
