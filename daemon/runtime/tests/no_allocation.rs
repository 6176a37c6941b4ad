//! genom3.md 7.4: a task's tick allocates nothing.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::time::Duration;

use genom_allocations as allocations;
use genom_description::model::Owner;
use genom_runtime::{
    Beats, Bounds, Change, Happening, Ix as _, Order, Part, Program, Rule, Supervised, TaskIx,
    Watcher,
};
use support::closures::{Closures, Codel, LONG, next, request};

struct Blind;

impl Watcher for Blind {
    fn changed(&self, _: &Change) {}
}

#[test]
fn ten_thousand_ticks_allocate_nothing() {
    const WARM: u64 = 100;
    const TICKS: u64 = 10_000;
    let (sender, counted) = channel();
    let state = Mutex::new((0u64, 0u64));
    let tick: Codel = Arc::new(move || {
        let calls = allocations::count();
        let mut state = state.lock().unwrap();
        state.0 += 1;
        if state.0 == WARM {
            state.1 = calls;
        }
        if state.0 == WARM + TICKS {
            sender.send(calls - state.1).unwrap();
        }
        "pause::start"
    });
    let again = |event: &'static str| -> Codel { Arc::new(move || event) };
    let body = Closures::new(
        "component test {
           ids { long a; };
           event beat;
           task t { period 100 us; codel<start> tick(inout a) yield pause::start; };
           task u { };
           function f() { codel fun(inout a); };
           activity busy() {
             task t;
             codel<start> one() yield main;
             codel<main> two() yield pause::start;
             codel<beat> extra() yield ether;
           };
           activity brief() { task t; codel<start> end() yield ether; };
           activity aside() { task u; codel<start> wait(in a) yield pause::start; };
         };",
        &[
            ("tick", tick),
            ("one", again("main")),
            ("two", again("pause::start")),
            ("end", again("ether")),
            ("extra", again("ether")),
            ("wait", again("pause::start")),
        ],
    );
    // Rules that each tick breaks.
    let (task, model) = (TaskIx::new(0), body.plan.component());
    let of = |name: &str| {
        let pairs = model.codels.pairs();
        pairs.filter_map(|(ix, codel)| (codel.name == name).then_some(ix)).collect::<Vec<_>>()
    };
    let state = |name| model.state(name).unwrap();
    let busy = body.plan.service("busy").unwrap();
    let ticks: Vec<Happening> = of("tick").into_iter().map(Happening::Call).collect();
    let (states, never) = (vec!["a".into(), "b".into()], vec![Happening::Fire(0)]);
    let order = Order::new(
        states,
        vec![("tick".into(), ticks.clone()), ("beat".into(), never)],
        &[(0, 1, 1), (1, 0, 0)],
    );
    let within = Bounds { least: 1_000, most: 20_000 };
    let parts = [
        (Part::Happens(ticks), "tick"),
        (Part::Runs(busy), "run(busy)"),
        (Part::Since(within, 1, 0), "run(busy) since[1 us, 20 us] tick"),
        (Part::Not(0), "not tick"),
        (Part::And(2, 3), "run(busy) since[1 us, 20 us] tick and not tick"),
    ];
    let formula =
        Program::new(parts.into_iter().map(|(part, text)| (part, text.to_owned())).collect());
    let rules = [
        Rule::Longest { codels: vec![(of("tick")[0], Duration::ZERO)] },
        Rule::Missed { task, ticks: 1, within: Duration::from_secs(1) },
        Rule::During { codels: of("tick"), service: busy },
        Rule::After { codels: of("two"), first: of("extra") },
        Rule::Step { owner: Owner::Service(busy), from: state("start"), to: state("main") },
        Rule::Cycle { task, longest: Duration::from_nanos(1) },
        Rule::Beat {
            of: Beats::Codels(of("tick")),
            least: Duration::from_secs(1),
            longest: Duration::from_secs(2),
            during: None,
        },
        Rule::Order(order.unwrap()),
        Rule::Formula(formula.unwrap()),
    ];
    let instance = body.start_with(|options| {
        options.watcher = Some(Arc::new(Blind));
        let all = rules.into_iter().map(|rule| Supervised { rule, interrupts: false });
        options.rules = all.collect();
    });
    let _busy = [request(&instance, "busy"), request(&instance, "busy")];
    let _aside = request(&instance, "aside");
    // Activities start and end, and requests contend, while the ticks are counted.
    let allocated = loop {
        if let Ok(allocated) = counted.try_recv() {
            break allocated;
        }
        let short = request(&instance, "brief");
        next(&short);
        assert_eq!(next(&short), "done");
        assert_eq!(next(&request(&instance, "f")), "done");
        instance.fire(0).unwrap();
    };
    assert_eq!(allocated, 0);
    let all = instance.violations();
    let [long, _, during, after, step, cycle, beat, order, formula] = all[..] else {
        panic!("nine rules")
    };
    assert!(long >= TICKS && during > 0 && after > 0 && step > 0, "{all:?}");
    assert!(cycle >= TICKS && beat >= TICKS && order > 0 && formula >= TICKS, "{all:?}");
    instance.shutdown(LONG).unwrap();
}
