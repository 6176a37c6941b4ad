//! The structured model for UPPAAL says what we find of components. There is no engine for it that is
//! free to use in tests, so the model is read and explored here: what is not in the language, or is not
//! known, ends the test.

#![allow(clippy::unwrap_used, clippy::panic)]

mod code;
mod compare;
#[path = "../../../formal/tests/conformance/components.rs"]
mod components;
mod declare;
mod explore;
mod express;
mod file;
mod lex;
mod memory;
mod names;
#[path = "../../../formal/tests/conformance/random.rs"]
mod random;
#[path = "../spin/small.rs"]
mod small;

use std::path::Path;

use compare::compare;
use genom_description::{Options, read};
use genom_formal::{Bounds, System};
use small::{made, system};

/// The system of a description of this repository.
fn repository(path: &str, bounds: Bounds) -> System {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    made(read(&[root.join(path)], &Options::default()), bounds)
}

#[test]
fn the_demo_and_the_figures_of_the_papers_have_as_many_states_and_the_same_verdicts() {
    for path in [
        "components/demo/demo.gen",
        "daemon/description/tests/papers/figure-2010.gen",
        "daemon/description/tests/papers/figure-2011.gen",
    ] {
        let began = std::time::Instant::now();
        let compared = compare(&repository(path, Bounds::default()), 200_000);
        println!("{path}: {compared:?} {:?}", began.elapsed());
    }
}
#[test]
fn random_components_have_as_many_states_and_the_same_verdicts() {
    for seed in 0..60 {
        let began = std::time::Instant::now();
        let compared = compare(&small::random(seed), 20_000);
        println!("{seed}: {compared:?} {:?}", began.elapsed());
    }
    let _ = system;
}
