//! Memory of searches: the limit is one of what is allocated.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use genom_formal::{Bounds, Duration, Formula, Limits, Property, System, Times, Verdict};
use support::{limits, system};

#[path = "sizes/component.rs"]
mod component;
#[path = "conformance/random.rs"]
mod random;

/// Limits at different places between two sizes of a list that doubles.
const MEMORY: [usize; 4] = [3 << 20, 4 << 20, 5 << 20, 7 << 20];
/// What the component itself takes, a state, and what is told.
const BESIDE: usize = 512 << 10;

/// The description of a component that is too large for these limits, whose tasks have periods.
fn text() -> String {
    let size = component::Size { tasks: 2, activities: 6, functions: 3 };
    let mut all = (0..).map(|seed| component::component(&mut random::Random(seed), size));
    all.find(|text| text.matches("period").count() == size.tasks).unwrap()
}

fn large() -> (System, Times) {
    let system = system(&text(), Bounds { kill: false, ..Bounds::default() }, true);
    let mut times = system.declared_times();
    let names = system.plan().component().codels.iter().map(|codel| codel.name.clone());
    for name in names.collect::<Vec<_>>() {
        let duration = Duration { least: 10_000, most: Some(900_000) };
        times.set(system.plan().component(), &name, duration);
    }
    (system, times)
}

/// What a search holds at once is within its limit, and not far below where the limit ends it.
fn is_within(search: impl Fn(&Limits) -> bool) {
    for memory in MEMORY {
        let limits = Limits { memory, ..limits() };
        let mut ended = false;
        let held = genom_allocations::most_held(|| ended = search(&limits));
        assert!(ended, "{memory} bytes were enough");
        assert!(held <= memory + BESIDE, "{held} bytes are held, {memory} allowed");
        assert!(held >= memory / 6, "{held} bytes are held, {memory} allowed");
    }
}

fn is_ended(verdict: &Verdict) -> bool {
    matches!(verdict, Verdict::Undecided(why) if why.contains("MiB"))
}

#[test]
fn properties_of_states_take_no_more_memory_than_they_may() {
    let (system, _) = large();
    is_within(|limits| {
        let report = system.check(&[Property::Start, Property::Exclude], limits);
        report.explored.unwrap().limit.is_some()
    });
}

#[test]
fn whether_requests_are_answered_takes_no_more_memory_than_it_may() {
    // An event that begins what may sleep: the rules do not decide, though it does not come.
    let text = text().replacen("component big {", "component big { event alarm;", 1);
    let text = format!("{}{SLEEPS}", text.trim_end().strip_suffix("};").unwrap());
    let system = system(&text, Bounds { fire: false, ..Bounds::default() }, true);
    is_within(|limits| is_ended(&system.check(&[Property::Answer], limits).verdicts[0].1));
}

const SLEEPS: &str = "activity sleeps() { task t0; codel<start> s0() yield pause::start, ether;
    codel<alarm> s1() yield sleep, ether; codel<stop> s2() yield ether; }; };";

#[test]
fn zones_take_no_more_memory_than_they_may() {
    let (system, times) = large();
    is_within(|limits| system.check_times(&times, limits).explored.limit.is_some());
    is_within(|limits| !system.respond(&times, limits).is_empty());
}

#[test]
fn formulas_take_no_more_memory_than_they_may() {
    let (system, _) = large();
    let past = Formula::new(&system, "[] (run(a0) -> once run(a0))").unwrap();
    is_within(|limits| is_ended(&system.check_past(&past, limits).unwrap()));
    let comes = Formula::new(&system, "[] (pending(a0) -> <> !pending(a0))").unwrap();
    is_within(|limits| is_ended(&system.check_comes(&comes, limits).unwrap()));
}
