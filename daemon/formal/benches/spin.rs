//! Spin and our explorer on random components:
//! `cargo bench --workspace --bench spin -- 500`, or with the first seed as a second number.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[path = "../tests/spin/compare.rs"]
mod compare;
#[path = "../tests/conformance/components.rs"]
mod components;
#[path = "../tests/spin/formulas.rs"]
mod formulas;
#[path = "../tests/conformance/random.rs"]
mod random;
#[path = "../tests/spin/run.rs"]
mod run;
#[path = "../tests/spin/small.rs"]
mod small;

fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|given| given.parse().ok()).collect();
    let (wanted, first) = (numbers.first().unwrap_or(&50), numbers.get(1).unwrap_or(&0));
    let (mut components, mut verdicts, mut states, mut large) = (0, 0, 0, 0);
    for seed in *first.. {
        if verdicts as u64 >= *wanted {
            break;
        }
        let system = small::random(seed);
        match compare::compare(&system, 20_000, 4) {
            Some(compared) => {
                components += 1;
                verdicts += compared.verdicts;
                states += compared.states;
                println!("seed {seed}: {} states", compared.states);
            }
            None => large += 1,
        }
    }
    println!("{components} components, {verdicts} verdicts and {states} states: no difference");
    println!("left out, since they have more states: {large}");
    let mut all = formulas::Judged::default();
    for judged in (*first..).filter_map(|seed| formulas::judge(seed, 5_000)) {
        all.add(judged);
        if (all.never.1 + all.comes.1) as u64 * 5 >= *wanted {
            break;
        }
    }
    let of = |(hold, all): (usize, usize)| format!("{all}, of which {hold} hold");
    println!("formulas that something never is: {}", of(all.never));
    println!("formulas that something comes: {}; no difference", of(all.comes));
}
