//! What a rule adds to each call of the codel that it is about: 0, 1 and 8 of a kind, next to the
//! call itself.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use genom_runtime::{Beats, Bounds, CodelIx, Happening, Order, Part, Program, Rule, Supervised};
use support::closures::{Closures, Codel, LONG};

const CALLS: u64 = 2_000_000;
/// Runs of each, of which the fastest counts.
const RUNS: usize = 5;

/// A rule about the calls of a codel.
type Make = fn(Vec<CodelIx>) -> Rule;

fn main() {
    let bare = (0..RUNS).map(|_| bare()).fold(f64::MAX, f64::min);
    println!("codel alone                          {bare:8.1} ns a call");
    let none = fastest(0, deadline);
    println!("in a task, no rule                   {none:8.1} ns a call");
    let kinds: [(&str, Make); 5] = [
        ("deadline", deadline),
        ("heartbeat", heartbeat),
        ("order", order),
        ("formula: a -> once[0, 1 s] a", formula),
        ("formula of 16 parts", long_formula),
    ];
    for (name, make) in kinds {
        for count in [1, 8] {
            let ns = fastest(count, make);
            let each = (ns - none) / count as f64;
            println!("{count} x {name:32} {ns:8.1} ns a call, {each:6.1} ns each");
        }
    }
}

fn fastest(count: usize, make: Make) -> f64 {
    (0..RUNS).map(|_| with_rules(count, make)).fold(f64::MAX, f64::min)
}

fn counting(done: impl Fn() + Send + Sync + 'static) -> Codel {
    let count = AtomicU64::new(0);
    Arc::new(move || {
        let calls = count.load(Ordering::Relaxed) + 1;
        count.store(calls, Ordering::Relaxed);
        if calls.is_multiple_of(CALLS) {
            done();
            return "ether";
        }
        "start"
    })
}

#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
fn each(took: Duration) -> f64 {
    took.as_secs_f64() * 1e9 / CALLS as f64
}

fn bare() -> f64 {
    let codel = counting(|| {});
    let begin = Instant::now();
    while std::hint::black_box(codel()) == "start" {}
    each(begin.elapsed())
}

fn with_rules(count: usize, make: Make) -> f64 {
    let (sender, ended) = channel();
    let sender = Mutex::new(sender);
    let codel = counting(move || {
        let _ = sender.lock().unwrap().send(());
    });
    let body = Closures::new(
        "component test {
           ids { long a; };
           task t { codel<start> c(inout a) yield start, ether; };
           attribute set(in a);
         };",
        &[("c", codel)],
    );
    let codels: Vec<CodelIx> = body.plan.component().codels.pairs().map(|(ix, _)| ix).collect();
    let begin = Instant::now();
    let instance = body.start_with(|options| {
        let rule = || Supervised { rule: make(codels.clone()), interrupts: false };
        options.rules = (0..count).map(|_| rule()).collect();
    });
    ended.recv().unwrap();
    let took = each(begin.elapsed());
    assert!(instance.violations().iter().all(|count| *count == 0), "{:?}", instance.violations());
    instance.shutdown(LONG).unwrap();
    took
}

fn deadline(codels: Vec<CodelIx>) -> Rule {
    Rule::Longest { codels: codels.into_iter().map(|codel| (codel, LONG)).collect() }
}

fn heartbeat(codels: Vec<CodelIx>) -> Rule {
    let of = Beats::Codels(codels);
    Rule::Beat { of, least: Duration::ZERO, longest: LONG, during: None }
}

fn calls(codels: &[CodelIx]) -> Vec<Happening> {
    codels.iter().map(|codel| Happening::Call(*codel)).collect()
}

fn order(codels: Vec<CodelIx>) -> Rule {
    let events = vec![("c".to_owned(), calls(&codels))];
    Rule::Order(Order::new(vec!["a".into(), "b".into()], events, &[(0, 0, 1), (1, 0, 0)]).unwrap())
}

fn formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    program(vec![Part::Happens(calls(&codels)), Part::Once(within, 0), Part::Implies(0, 1)])
}

/// Once after once, each with bounds.
fn long_formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    let mut parts = vec![Part::Happens(calls(&codels))];
    parts.extend((0..15).map(|before| Part::Once(within, before)));
    program(parts)
}

fn program(parts: Vec<Part>) -> Rule {
    let parts = parts.into_iter().map(|part| (part, String::new())).collect();
    Rule::Formula(Program::new(parts).unwrap())
}
