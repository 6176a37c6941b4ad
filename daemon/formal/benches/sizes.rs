//! How long components of real size take, and how much memory:
//! `cargo bench --workspace --bench sizes -- 10`, the number of components of each size.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[path = "../tests/sizes/component.rs"]
mod component;
#[path = "../tests/conformance/random.rs"]
mod random;

use std::sync::Arc;
use std::time::Instant;

use component::{Size, component};
use genom_description::{Options, read_text};
use genom_formal::{Bounds, Limits, Property, System, Verdict};
use genom_runtime::Plan;

fn main() {
    let count = std::env::args().filter_map(|given| given.parse().ok()).next().unwrap_or(5);
    println!("codels  tasks  activities   untimed s  states    ticks s   zones   not decided");
    for (tasks, activities, functions) in [(1, 2, 1), (2, 4, 2), (3, 7, 3), (3, 10, 4)] {
        let size = Size { tasks, activities, functions };
        for seed in 0..count {
            measure(size, seed);
        }
    }
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status.lines().find(|line| line.starts_with("VmHWM"));
        println!("most memory of all: {}", peak.unwrap_or("unknown"));
    }
}

fn measure(size: Size, seed: u64) {
    let text = component(&mut random::Random(seed), size);
    let analysis = read_text("sizes.gen", &text, &Options::default());
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    let system = System::new(&plan, Bounds::default());
    let begin = Instant::now();
    let report = system.check(&Property::ALL, &Limits::default());
    let untimed = begin.elapsed();
    let mut open: Vec<&str> = Vec::new();
    for (property, verdict) in &report.verdicts {
        if matches!(verdict, Verdict::Undecided(_)) {
            open.push(property.name());
        }
    }
    let system = System::new(&plan, Bounds { kill: false, ..Bounds::default() });
    let begin = Instant::now();
    let ticks = system.check_ticks(&system.declared_times(), &Limits::default());
    let timed = begin.elapsed();
    open.extend(ticks.tasks.iter().filter(|task| task.is_open()).map(|_| "overrun"));
    let late = ticks.tasks.iter().filter(|task| task.is_late()).count();
    println!(
        "{:6} {:6} {:11} {:11.2} {:8} {:9.2} {:8}   {open:?} late {late}",
        plan.component().codels.len(),
        size.tasks,
        size.activities,
        untimed.as_secs_f64(),
        report.explored.map_or(0, |explored| explored.len()),
        timed.as_secs_f64(),
        ticks.explored.zones(),
    );
}
