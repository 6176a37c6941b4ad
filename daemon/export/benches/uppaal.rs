//! The structured model for UPPAAL and our explorer on random components:
//! `cargo bench --workspace --bench uppaal -- 200`, or with the first seed as a second number.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

#[path = "../tests/uppaal/code.rs"]
mod code;
#[path = "../tests/uppaal/compare.rs"]
mod compare;
#[path = "../../formal/tests/conformance/components.rs"]
mod components;
#[path = "../tests/uppaal/declare.rs"]
mod declare;
#[path = "../tests/uppaal/explore.rs"]
mod explore;
#[path = "../tests/uppaal/express.rs"]
mod express;
#[path = "../tests/uppaal/file.rs"]
mod file;
#[path = "../tests/uppaal/graph.rs"]
mod graph;
#[path = "../tests/uppaal/lex.rs"]
mod lex;
#[path = "../tests/uppaal/memory.rs"]
mod memory;
#[path = "../tests/uppaal/names.rs"]
mod names;
#[path = "../../formal/tests/conformance/random.rs"]
mod random;
#[path = "../tests/spin/small.rs"]
mod small;
#[path = "../tests/uppaal/timed.rs"]
mod timed;

use std::time::Instant;

fn main() {
    let numbers: Vec<u64> = std::env::args().filter_map(|given| given.parse().ok()).collect();
    let (wanted, first) = (numbers.first().unwrap_or(&50), numbers.get(1).unwrap_or(&0));
    let (begin, seeds) = (Instant::now(), *first..*first + *wanted);
    let (mut components, mut all) = (0, compare::Compared::default());
    for compared in seeds.clone().filter_map(|seed| compare::compare(&small::random(seed), 20_000))
    {
        components += 1;
        all.states += compared.states;
        all.steps += compared.steps;
        all.verdicts += compared.verdicts;
    }
    let compare::Compared { states, steps, verdicts } = all;
    println!(
        "without times, {components} components: the same {states} states, {steps} steps and {verdicts} \
         verdicts"
    );
    let (mut components, mut in_time, mut late) = (0, 0, 0);
    for (system, times) in seeds.map(small::timed) {
        let Some(tasks) = timed::late(&system, &times, 200_000, 5_000) else { continue };
        components += 1;
        late += tasks.iter().filter(|(_, late)| *late).count();
        in_time += tasks.iter().filter(|(_, late)| !late).count();
    }
    println!("with times, {components} components: the same {in_time} tasks in time, {late} late");
    println!("{:.0?}", begin.elapsed());
}
