//! Spin finds the same of exported models as we do: verdicts, and as many states.
//!
//! `cargo bench --workspace --bench spin -- 500` compares more components.

#![allow(clippy::unwrap_used, clippy::panic)]

mod compare;
#[path = "../../../formal/tests/conformance/components.rs"]
mod components;
mod formulas;
#[path = "../../../formal/tests/conformance/random.rs"]
mod random;
mod run;
mod small;
mod tally;
mod timed;

use std::path::Path;

use compare::compare;
use formulas::{COMES, NEVER, judge};
use genom_description::{Options, read};
use genom_export::export_claim;
use genom_formal::{Bounds, Formula, System, Verdict};
use run::Checked;
use small::made;
use tally::Tally;

/// The system of a description of this repository.
fn repository(path: &str, bounds: Bounds) -> System {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    made(read(&[root.join(path)], &Options::default()), bounds)
}

/// No verdict is another one, and each is one.
fn all_equal(tally: &Tally) {
    assert!(tally.different.is_empty(), "{:#?}", tally.different);
    assert_eq!(tally.undecided(), 0, "{tally}");
}

#[test]
fn spin_finds_as_many_states_and_the_same_verdicts_of_random_components() {
    let (mut components, mut states, mut all) = (0, 0, Tally::default());
    for seed in 0.. {
        let system = small::random(seed);
        // Of every third one, the claims, too.
        let claims = if seed % 3 == 0 { 3 } else { 0 };
        if let Some(compared) = compare(&system, 20_000, claims) {
            components += 1;
            states += compared.states;
            all.add(compared.tally, format_args!("seed {seed}"));
        }
        if components == 4 {
            break;
        }
    }
    all_equal(&all);
    assert!(states > 1000, "{states}");
}

#[test]
fn spin_agrees_on_the_demo_and_on_the_figures_of_the_papers() {
    for (path, bounds) in [
        ("components/demo/demo.gen", Bounds::default()),
        ("daemon/description/tests/papers/figure-2010.gen", Bounds::default()),
        ("daemon/description/tests/papers/figure-2011.gen", Bounds::default()),
    ] {
        let system = repository(path, bounds);
        let compared = compare(&system, 200_000, 100).unwrap_or_else(|| panic!("{path}"));
        all_equal(&compared.tally);
    }
}

#[test]
fn spin_agrees_on_formulas_of_users() {
    let demo = || repository("components/demo/demo.gen", Bounds::default());
    let violated = |system: &System, text: &str| {
        let formula = Formula::new(system, text).unwrap();
        let model = export_claim(system, &formula, None).unwrap();
        let limits = compare::limits(200_000);
        let ours = system.check_past(&formula, &limits);
        let ours = ours.or_else(|| system.check_comes(&formula, &limits));
        let ours = ours.map(|verdict| matches!(verdict, Verdict::Violated(_)));
        (Checked::of(&model, false).user("user").unwrap(), ours)
    };
    for (text, expected) in [
        ("[] !(codel(demo_servo) && codel(demo_brake))", false),
        ("[] !(run(goto) && pending(goto))", true),
        // A servo loop may yield `pause` for ever, so it takes more than that each process goes on.
        ("[] (goto -> <> !goto)", true),
        ("[] (codel(demo_servo) -> <> !codel(demo_servo))", false),
    ] {
        assert_eq!(violated(&demo(), text), (expected, Some(expected)), "{text}");
    }
    // Of no form that is built in.
    let text = "[] (codel(demo_servo) -> codel(demo_servo) U !codel(demo_servo))";
    assert_eq!(violated(&demo(), text), (false, None));
}

#[test]
fn spin_agrees_on_random_formulas_that_something_comes_or_never_is() {
    let (mut all, mut components) = (Tally::default(), 0);
    for (seed, tally) in (0..).filter_map(|seed| Some((seed, judge(seed, 1_500)?))) {
        all.add(tally, format_args!("seed {seed}"));
        components += 1;
        if components == 3 {
            break;
        }
    }
    all_equal(&all);
    // Some hold, and some do not.
    for kind in [NEVER, COMES] {
        let (hold, fail) = all.of(kind);
        assert!(hold > 0 && fail > 0, "{all}");
    }
}

#[test]
fn spin_agrees_on_which_tasks_of_random_components_are_late() {
    let mut all = Tally::default();
    for (seed, tally) in (0..).filter_map(|seed| Some((seed, timed::judge(seed, 150)?))) {
        all.add(tally, format_args!("seed {seed}"));
        let (in_time, late) = all.equal();
        if !all.different.is_empty() || in_time + late >= 4 {
            break;
        }
    }
    all_equal(&all);
}

#[test]
fn spin_agrees_on_the_bound_of_two_tasks_that_share_data() {
    for (most, late) in [(6, false), (7, true), (8, true)] {
        let (system, times) = small::two_tasks(most);
        let report = system.check_times(&times, &compare::limits(100_000));
        let spin = Checked::new(&system, Some(&times));
        for (task, late) in [("fast", late), ("slow", false)] {
            let ours = report.tasks.iter().find(|report| report.name == task).unwrap();
            assert_eq!(!ours.overrun.is_empty(), late, "{task}, {most} ms");
            assert_eq!(spin.claim(&format!("in_time_{task}")), Some(late), "{task}, {most} ms");
        }
    }
}
