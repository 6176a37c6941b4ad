//! The structured model for UPPAAL says what we find of components. There is no engine for it that is
//! free to use in tests, so the model is read and explored here: what is not in the language, or is not
//! known, ends the test.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

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
fn the_demo_and_the_figures_of_the_papers_have_the_same_states_steps_and_verdicts() {
    for path in [
        "components/demo/demo.gen",
        "daemon/description/tests/papers/figure-2010.gen",
        "daemon/description/tests/papers/figure-2011.gen",
    ] {
        let compared = compare(&repository(path, Bounds::default()), 200_000);
        assert!(compared.is_some_and(|all| all.states > 1_000), "{path}: {compared:?}");
    }
}

#[test]
fn random_components_have_the_same_states_steps_and_verdicts() {
    let all = (0..).filter_map(|seed| compare(&small::random(seed), 5_000)).take(12);
    let all: Vec<compare::Compared> = all.collect();
    let sum = |of: fn(&compare::Compared) -> usize| all.iter().map(of).sum::<usize>();
    let sums = (sum(|one| one.states), sum(|one| one.steps), sum(|one| one.verdicts));
    assert!(sums.0 > 5_000 && sums.1 > 15_000 && sums.2 > 100, "{sums:?}");
}

#[test]
fn two_tasks_that_share_data_are_late_as_we_find() {
    for (most, late) in [(6, false), (7, true), (8, true)] {
        let (system, times) = small::two_tasks(most);
        let late = [("fast".to_owned(), late), ("slow".to_owned(), false)];
        assert_eq!(timed::late(&system, &times, 100_000, 100_000).unwrap(), late, "{most} ms");
    }
}

#[test]
fn tasks_of_random_components_are_late_as_we_find() {
    let (mut in_time, mut are_late) = (0, 0);
    for seed in 0.. {
        let (system, times) = small::timed(seed);
        for (_, late) in timed::late(&system, &times, 50_000, 1_000).unwrap_or_default() {
            *if late { &mut are_late } else { &mut in_time } += 1;
        }
        if in_time >= 10 && are_late >= 2 {
            break;
        }
    }
}

#[test]
fn time_that_passes_where_the_runtime_does_something_at_once_is_noticed() {
    let (system, times) = small::two_tasks(6);
    let text = timed::written(&system, &times);
    let of = |from: &str| {
        let changed = text.replace(from, "");
        assert_ne!(changed, text, "{from}");
        let found = timed::found(&changed, 100_000).unwrap();
        (found.graph.steps.len(), found.holds("overrun: task fast "))
    };
    let found = timed::found(&text, 100_000).unwrap();
    assert!(found.holds("overrun: task fast "));
    assert!(!of("<label kind=\"synchronisation\">now!</label>").1);
    // Clocks that are not set when a codel begins.
    assert_ne!(of("since[idle(0)] = 0, ").0, found.graph.steps.len());
}
