//! The structured model for UPPAAL says what we find of components. There is no engine for it that is
//! free to use in tests, so the model is read and explored here: what is not in the language, or is not
//! known, ends the test.

#![allow(clippy::unwrap_used, clippy::panic)]

mod changed;
mod code;
mod compare;
#[path = "../../../formal/tests/conformance/components.rs"]
mod components;
mod declare;
mod explore;
mod express;
mod file;
mod graph;
mod lex;
mod memory;
mod names;
#[path = "../../../formal/tests/conformance/random.rs"]
mod random;
mod semantics;
#[path = "../spin/small.rs"]
mod small;
mod timed;

use std::path::Path;

use compare::compare;
use genom_description::{Options, read};
use genom_formal::{Bounds, System};
use small::made;

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
}

#[test]
fn tasks_that_share_data_are_late_as_we_find() {
    for (most, late) in [(6, false), (7, true), (8, true)] {
        let (system, times) = small::two_tasks(most);
        let found = timed::late(&system, &times, (100_000, 100_000)).unwrap();
        println!("{found:?}");
        assert_eq!(found.1, [("fast".to_owned(), late), ("slow".to_owned(), false)], "{most} ms");
    }
    for seed in 0..100 {
        let (system, times) = small::timed(seed);
        let began = std::time::Instant::now();
        let found = timed::late(&system, &times, (50_000, 1_000));
        println!("{seed}: {found:?} {:?}", began.elapsed());
    }
}
