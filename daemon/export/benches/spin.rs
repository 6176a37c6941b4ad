//! Spin and our explorer on random components:
//! `cargo bench --workspace --bench spin -- 500`, or with the first seed as a second number.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[path = "../tests/spin/compare.rs"]
mod compare;
#[path = "../../formal/tests/conformance/components.rs"]
mod components;
#[path = "../tests/spin/formulas.rs"]
mod formulas;
#[path = "../../formal/tests/conformance/random.rs"]
mod random;
#[path = "../tests/spin/run.rs"]
mod run;
#[path = "../tests/spin/small.rs"]
mod small;
#[path = "../tests/spin/tally.rs"]
mod tally;
#[path = "../tests/spin/timed.rs"]
mod timed;

use std::time::Instant;

use tally::Tally;

fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|given| given.parse().ok()).collect();
    let (wanted, first) = (numbers.first().unwrap_or(&50), numbers.get(1).unwrap_or(&0));
    let wanted = usize::try_from(*wanted).unwrap();
    let begin = Instant::now();
    let mut all = Tally::default();
    // Half of the verdicts are about states, three of ten are on formulas, the rest on time.
    let (states, formulas) = (wanted * 5 / 10, wanted * 8 / 10);
    let mut add = |until: usize, judge: &dyn Fn(u64) -> Option<Tally>| {
        let (mut components, mut left_out) = (0, 0);
        for seed in *first.. {
            let (hold, fail) = all.equal();
            if hold + fail >= until || left_out > 1000 {
                break;
            }
            match judge(seed) {
                Some(tally) => {
                    components += 1;
                    tally.different.iter().for_each(|one| println!("seed {seed}: {one}"));
                    all.add(tally, format_args!("seed {seed}"));
                }
                None => left_out += 1,
            }
        }
        println!("{components} components; {left_out} have more states, or no such verdict");
    };
    add(states, &|seed| Some(compare::compare(&small::random(seed), 20_000, 4)?.tally));
    add(formulas, &|seed| formulas::judge(seed, 5_000));
    add(wanted, &|seed| timed::judge(seed, 600));
    print!("{all}");
    println!("{:.0?}", begin.elapsed());
    assert!(all.different.is_empty(), "{:#?}", all.different);
}
