//! How long components of real size take, and how much memory:
//! `cargo bench --workspace --bench sizes -- 10`, the number of components of each size; with the first
//! seed behind it; and then with the most codels of its own that a component of three tasks and ten
//! activities may have, of which alone there are as many then. Or `-- FILE.gen`, with the bounds of
//! `genomctl verify` and with fewer.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[path = "../tests/sizes/component.rs"]
mod component;
#[path = "../tests/conformance/random.rs"]
mod random;

use std::sync::Arc;
use std::time::Instant;

use component::{Size, component};
use genom_description::model::{Codel, Owner};
use genom_description::{Analysis, Options, read, read_text};
use genom_formal::{Bounds, Limits, Longest, Property, System, Verdict};
use genom_runtime::Plan;

fn main() {
    let files: Vec<String> = std::env::args().filter(|given| given.ends_with(".gen")).collect();
    if !files.is_empty() {
        return files.iter().for_each(|file| measure_file(file));
    }
    let numbers: Vec<u64> = std::env::args().filter_map(|given| given.parse().ok()).collect();
    let (count, first) = (numbers.first().unwrap_or(&5), numbers.get(1).unwrap_or(&0));
    println!(
        "seed codels (own)  tasks  activities   untimed s  states    ticks s   zones   not decided"
    );
    let (mut slowest, mut open, mut all) = (0.0f64, 0, 0);
    let most = numbers.get(2).and_then(|most| usize::try_from(*most).ok());
    let sizes: &[_] = match most {
        Some(_) => &[(3, 10, 1)],
        None => &[(1, 2, 1), (2, 4, 2), (3, 7, 3), (3, 10, 4)],
    };
    for (tasks, activities, functions) in sizes.iter().copied() {
        let size = Size { tasks, activities, functions };
        for seed in *first..first + count {
            let text = component(&mut random::Random(seed), size);
            let analysis = read_text("sizes.gen", &text, &Options::default());
            if most.is_some_and(|most| own_codels(&analysis) > most) {
                continue;
            }
            print!("{seed:4} ");
            let (took, undecided) = measure(analysis, Bounds::default());
            slowest = slowest.max(took);
            open += usize::from(undecided);
            all += 1;
        }
    }
    println!("{all} components, {open} with something that is not decided, slowest {slowest:.1} s");
    peak();
}

/// Codels that a component has beside those of standard services.
fn own_codels(analysis: &Analysis) -> usize {
    let component = &analysis.specification.components[0];
    let is_own = |codel: &Codel| match codel.owner {
        Owner::Service(service) => !component.services[service].standard,
        Owner::Task(_) => true,
    };
    component.codels.iter().filter(|codel| is_own(codel)).count()
}

/// The most memory that was taken.
fn peak() {
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().find(|line| line.starts_with("VmHWM"));
        println!("most memory of all: {}", peak.unwrap_or("unknown"));
    }
}

fn measure_file(file: &str) {
    let all = Bounds::default();
    let few = Bounds { instances: 1, abort: false, fire: false, ..all };
    for bounds in [few, Bounds { instances: 1, ..all }, all, Bounds { requests: 2, ..all }] {
        println!("{file}: {bounds:?}");
        measure(read(&[file], &Options::default()), bounds);
        measure_zones(read(&[file], &Options::default()), bounds);
    }
    peak();
}

/// The zones of the component as a whole.
fn measure_zones(analysis: Analysis, bounds: Bounds) {
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    let system = System::new(&plan, Bounds { kill: false, ..bounds });
    let mut times = system.declared_times();
    times.bound_others(1_000_000);
    let begin = Instant::now();
    let found = system.check_times(&times, &Limits::default());
    let (states, zones) = (found.explored.states(), found.explored.zones());
    let took = begin.elapsed().as_secs_f64();
    println!("  as a whole: {states} states, {zones} zones, {took:.2} s, {:?}", found.limit());
    for task in &found.tasks {
        println!("  {}: {:?} ns, late {}", task.name, task.response, task.is_late());
    }
}

/// Prints what is found of a component; returns how long that took, and whether something is not
/// decided.
fn measure(analysis: Analysis, bounds: Bounds) -> (f64, bool) {
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let own = own_codels(&analysis);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    let system = System::new(&plan, bounds);
    let begin = Instant::now();
    let report = system.check(&Property::ALL, &Limits::default());
    let untimed = begin.elapsed();
    let mut open: Vec<&str> = Vec::new();
    for (property, verdict) in &report.verdicts {
        if matches!(verdict, Verdict::Undecided(_)) {
            open.push(property.name());
        }
    }
    let system = System::new(&plan, Bounds { kill: false, ..bounds });
    let mut times = system.declared_times();
    times.bound_others(1_000_000);
    let begin = Instant::now();
    let ticks = system.check_ticks(&times, &Limits::default());
    // As `genomctl verify` does if it is not asked for.
    let responses = system.respond(&times, &Limits::default().first());
    let timed = begin.elapsed();
    open.extend(ticks.tasks.iter().filter(|task| task.is_open()).map(|_| "overrun"));
    let late = ticks.tasks.iter().filter(|task| task.is_late()).count();
    let is_open = |one: &Longest| matches!(one, Longest::Undecided(_));
    let known = responses.iter().filter(|one| !is_open(&one.begins) && !is_open(&one.ends)).count();
    let component = plan.component();
    let activities = component.services.iter().filter(|service| service.task.is_some()).count();
    println!(
        "{:6} {own:5} {:6} {activities:11} {:11.2} {:8} {:9.2} {:8}   {open:?} late {late}, {known} of {} responses",
        component.codels.len(),
        component.tasks.len(),
        untimed.as_secs_f64(),
        report.explored.map_or(0, |explored| explored.states),
        timed.as_secs_f64(),
        ticks.explored.zones(),
        responses.len(),
    );
    ((untimed + timed).as_secs_f64(), !open.is_empty())
}
