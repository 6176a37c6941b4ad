//! Spin finds the same of exported models as we do: verdicts, and as many states.
//!
//! `cargo bench --workspace --bench spin -- 500` compares more components.

#![allow(clippy::unwrap_used, clippy::panic)]

mod compare;
#[path = "../conformance/components.rs"]
mod components;
mod formulas;
#[path = "../conformance/random.rs"]
mod random;
mod run;
mod small;

use std::path::Path;

use compare::compare;
use formulas::{Judged, judge};
use genom_description::{Options, read};
use genom_formal::{Bounds, Duration, Formula, System, Times, Verdict};
use run::Checked;
use small::{made, system};

const MS: u64 = 1_000_000;

/// The system of a description of this repository.
fn repository(path: &str, bounds: Bounds) -> System {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    made(read(&[root.join(path)], &Options::default()), bounds)
}

#[test]
fn spin_finds_as_many_states_and_the_same_verdicts_of_random_components() {
    let (mut components, mut states) = (0, 0);
    for seed in 0.. {
        let system = small::random(seed);
        // Of every third one, the claims, too.
        let claims = if seed % 3 == 0 { 3 } else { 0 };
        if let Some(compared) = compare(&system, 20_000, claims) {
            components += 1;
            states += compared.states;
        }
        if components == 4 {
            break;
        }
    }
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
        assert!(compare(&system, 200_000, 100).is_some(), "{path}");
    }
}

#[test]
fn spin_agrees_on_formulas_of_users() {
    let demo = || repository("components/demo/demo.gen", Bounds::default());
    let violated = |system: &System, text: &str| {
        let formula = Formula::new(system, text).unwrap();
        let model = system.export_claim(&formula, None).unwrap();
        let limits = compare::limits(200_000);
        let ours = system.check_past(&formula, &limits);
        let ours = ours.or_else(|| system.check_comes(&formula, &limits));
        let ours = ours.map(|verdict| matches!(verdict, Verdict::Violated(_)));
        (Checked::of(&model, false).user("user"), ours)
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
    let (mut all, mut components) = (Judged::default(), 0);
    for judged in (0..).filter_map(|seed| judge(seed, 1_500)) {
        all.add(judged);
        components += 1;
        if components == 3 {
            break;
        }
    }
    // Some hold, and some do not.
    for (hold, of) in [all.never, all.comes] {
        assert!(0 < hold && hold < of, "{all:?}");
    }
}

#[test]
fn spin_agrees_on_the_bound_of_two_tasks_that_share_data() {
    let text = "component duo { ids { long shared; };
      task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start; };
      task slow { period 40 ms; codel<start> sb(inout shared) yield work;
        codel<work> sw() yield pause::start; }; };";
    for (most, late) in [(6, false), (7, true), (8, true)] {
        let bounds = Bounds { kill: false, ..Bounds::default() };
        let system = system(text, bounds, false);
        let mut times: Times = system.declared_times();
        for (codel, most) in [("fa", 3), ("sb", most), ("sw", 20)] {
            let duration = Duration { least: MS, most: Some(most * MS) };
            assert!(times.set(system.plan().component(), codel, duration));
        }
        let report = system.check_times(&times, &compare::limits(100_000));
        let spin = Checked::new(&system, Some(&times));
        for (task, late) in [("fast", late), ("slow", false)] {
            let ours = report.tasks.iter().find(|report| report.name == task).unwrap();
            assert_eq!(!ours.overrun.is_empty(), late, "{task}, {most} ms");
            assert_eq!(spin.claim(&format!("in_time_{task}")), late, "{task}, {most} ms");
        }
    }
}
