//! What a rule adds to each call of the codel that it is about: 0, 1 and 8 of a kind, next to the
//! call itself.
//!
//! `cargo bench -p genom-runtime --bench monitors [-- WORD...]`: of the kinds whose name has one of
//! these words.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use genom_runtime::{
    Beats, Bounds, CodelIx, Happening, Ix as _, Order, Part, Program, Rule, ServiceIx, Supervised,
};
use support::closures::{Closures, Codel, LONG};

/// Calls of a run.
const CALLS: u64 = 1_000_000;
/// Calls that are timed together, of which the fastest count: so few that some of them are disturbed
/// by nothing else, if the machine has other work, too.
const TOGETHER: u64 = 10_000;
/// Runs of each: one of all after the other, so that what disturbs the machine for a while disturbs
/// all.
const RUNS: usize = 12;

/// A rule about the calls of a codel.
type Make = fn(Vec<CodelIx>) -> Rule;

fn main() {
    let kinds: [(&str, Make); 8] = [
        ("deadline", deadline),
        ("heartbeat", heartbeat),
        ("order", order),
        ("formula: a -> once[0, 1 s] a", formula),
        ("formula of 16 parts", long_formula),
        ("formula of 18 parts, two events", mixed_formula),
        // What else they hear of happens in other threads, if it does.
        ("order of several threads", shared_order),
        ("formula of several threads", shared_formula),
    ];
    // `cargo bench` adds `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let is_wanted = |(name, _): &(&str, Make)| {
        words.is_empty() || words.iter().any(|word| name.contains(word.as_str()))
    };
    let counted = |(name, make)| [1, 8].map(|count| (name, count, make, f64::MAX));
    let wanted = kinds.into_iter().filter(is_wanted);
    let mut all: Vec<(&str, usize, Make, f64)> = wanted.flat_map(counted).collect();
    let (mut alone, mut none) = (f64::MAX, f64::MAX);
    for _ in 0..RUNS {
        alone = alone.min(bare());
        none = none.min(with_rules(0, deadline));
        for (_, count, make, ns) in &mut all {
            *ns = ns.min(with_rules(*count, *make));
        }
    }
    println!("codel alone                          {alone:8.1} ns a call");
    println!("in a task, no rule                   {none:8.1} ns a call");
    for (name, count, _, ns) in all {
        let each = (ns - none) / count as f64;
        println!("{count} x {name:32} {ns:8.1} ns a call, {each:6.1} ns each");
    }
}

/// A codel that is called so often, and what it takes: the time from one call to the next, of the
/// fastest that were timed together, in nanoseconds.
fn counting(done: impl Fn() + Send + Sync + 'static) -> (Codel, Arc<AtomicU64>) {
    let (count, last) = (AtomicU64::new(0), AtomicU64::new(0));
    let fastest = Arc::new(AtomicU64::new(u64::MAX));
    let (own, epoch) = (Arc::clone(&fastest), Instant::now());
    let codel = Arc::new(move || {
        let calls = count.load(Ordering::Relaxed) + 1;
        count.store(calls, Ordering::Relaxed);
        if calls.is_multiple_of(TOGETHER) {
            let now = u64::try_from(epoch.elapsed().as_nanos()).unwrap();
            let took = now - last.swap(now, Ordering::Relaxed);
            own.fetch_min(took, Ordering::Relaxed);
            if calls.is_multiple_of(CALLS) {
                done();
                return "ether";
            }
        }
        "start"
    });
    (codel, fastest)
}

#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
fn each(fastest: &AtomicU64) -> f64 {
    fastest.load(Ordering::Relaxed) as f64 / TOGETHER as f64
}

fn bare() -> f64 {
    let (codel, fastest) = counting(|| {});
    while std::hint::black_box(codel()) == "start" {}
    each(&fastest)
}

fn with_rules(count: usize, make: Make) -> f64 {
    let (sender, ended) = channel();
    let sender = Mutex::new(sender);
    let (codel, fastest) = counting(move || {
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
    // Not those of the standard services, which are called elsewhere.
    let all = body.plan.component().codels.pairs();
    let codels: Vec<CodelIx> = all.filter(|(_, one)| one.name == "c").map(|(ix, _)| ix).collect();
    assert_eq!(codels.len(), 1);
    let instance = body.start_with(|options| {
        let rule = || Supervised { rule: make(codels.clone()), interrupts: false };
        options.rules = (0..count).map(|_| rule()).collect();
    });
    ended.recv().unwrap();
    assert!(instance.violations().iter().all(|count| *count == 0), "{:?}", instance.violations());
    instance.shutdown(LONG).unwrap();
    each(&fastest)
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

/// Something that happens outside tasks.
fn elsewhere() -> Happening {
    Happening::Accept(ServiceIx::new(0))
}

fn order(codels: Vec<CodelIx>) -> Rule {
    of_events(vec![("c".to_owned(), calls(&codels))])
}

fn shared_order(codels: Vec<CodelIx>) -> Rule {
    of_events(vec![("c".to_owned(), [calls(&codels), vec![elsewhere()]].concat())])
}

fn of_events(events: Vec<(String, Vec<Happening>)>) -> Rule {
    Rule::Order(Order::new(vec!["a".into(), "b".into()], events, &[(0, 0, 1), (1, 0, 0)]).unwrap())
}

fn formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    program(vec![Part::Happens(calls(&codels)), Part::Once(within, 0), Part::Implies(0, 1)])
}

fn shared_formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    let heard = [calls(&codels), vec![elsewhere()]].concat();
    program(vec![Part::Happens(heard), Part::Once(within, 0), Part::Implies(0, 1)])
}

/// Once after once, each with bounds.
fn long_formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    let mut parts = vec![Part::Happens(calls(&codels))];
    parts.extend((0..15).map(|before| Part::Once(within, before)));
    program(parts)
}

/// Parts of all kinds, which hear of each call and of its return.
fn mixed_formula(codels: Vec<CodelIx>) -> Rule {
    let within = Bounds { least: 0, most: 1_000_000_000 };
    let ever = Bounds { least: 0, most: u64::MAX };
    let returns = codels.iter().map(|codel| Happening::Return(*codel)).collect();
    program(vec![
        Part::Happens(calls(&codels)),
        Part::Happens(returns),
        Part::Once(within, 0),
        Part::Implies(1, 2),
        Part::Previous(0),
        Part::Implies(1, 4),
        Part::Previous(1),
        Part::Not(6),
        Part::Since(ever, 7, 0),
        Part::Implies(1, 8),
        Part::Or(0, 1),
        Part::Historically(within, 10),
        Part::Once(within, 1),
        Part::Or(12, 0),
        Part::And(3, 5),
        Part::And(14, 9),
        Part::And(15, 11),
        Part::And(16, 13),
    ])
}

fn program(parts: Vec<Part>) -> Rule {
    let parts = parts.into_iter().map(|part| (part, String::new())).collect();
    Rule::Formula(Program::new(parts).unwrap())
}
