//! A rule that is changed in the model is noticed: other states are found, or other verdicts.

use genom_formal::{Bounds, System};

use super::compare::{found, written};
use super::graph::Shape;
use super::small;

/// A rule, a part of its text, and what is there instead.
const CHANGES: [(&str, &str, &str); 14] = [
    ("R1: failures of the start-up are ignored", "failed = true;", "failed = false;"),
    (
        "R3: ended activities are prepared, not those that begin",
        "life == INIT) {\n    if (ticks",
        "life == INIT) {\n    if (!ticks",
    ),
    (
        "R4: a stop request counts on ticks only",
        "== RUN && T[t].r[x].asked) {",
        "== RUN && T[t].r[x].asked && ticks) {",
    ),
    ("R5: who waits is not looked at", "i < ahead; i++", "i < 0; i++"),
    (
        "R5: who holds a node is not looked at",
        "if (held[i] != 0) {",
        "if (held[i] != 0 && n < 0) {",
    ),
    (
        "R6: a pause is none",
        "kind == PAUSE) {\n    set_place(t, s, PAUSED)",
        "kind == PAUSE) {\n    set_place(t, s, READY)",
    ),
    ("R7: what ended is executed again", "p[i].mode != DONE) {", "p[i].mode != ASLEEP) {"),
    ("R8: nobody is woken", "if (i != but && PERIOD[i] == 0", "if (i == but && PERIOD[i] == 0"),
    ("R9: what ran is forgotten", "ran[s] = true;\n      }", "ran[s] = false;\n      }"),
    ("R10: before and after are ignored", "has_slot(s) && in_order(s)", "has_slot(s)"),
    ("R10: slots have no limit", "< SLOTS", "< NONE"),
    ("R12: nothing is interrupted", "if (stop(t, x)) changed = true;", "changed = true;"),
    (
        "R14: sleeping places stay",
        "if (T[t].r[x].p[i].mode != ASLEEP) {",
        "if (T[t].r[x].p[i].mode != DONE) {",
    ),
    (
        "R15: who has ended does not stop again",
        "again = T[t].r[x].asked",
        "again = false && T[t].r[x].asked",
    ),
];

/// States, steps, and verdicts.
type Told = (Shape, Vec<(String, bool)>);

/// What is found of a model; none if there are more states than the rules allow.
fn told(system: &System, text: &str, most: usize) -> Option<Told> {
    found(system, text, most).map(|found| (found.graph.shape(), found.verdicts))
}

/// Whether a change is noticed in one of these models.
fn is_noticed(models: &[(System, String, Told)], from: &str, to: &str) -> bool {
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    models.iter().any(|(system, text, expected)| {
        assert_eq!(text.matches(&escaped(from)).count(), 1, "{from}");
        let changed = text.replace(&escaped(from), &escaped(to));
        told(system, &changed, 2 * expected.0.0).is_none_or(|told| told != *expected)
    })
}

/// Components with what the rules are about.
const COMPONENTS: [&str; 4] = [
    // Who waits for one task is waited for by another one.
    "component c { ids { long a, b; };
       task t1 { period 5 ms; codel<start> c1(inout a) yield pause::start; };
       task t2 { period 5 ms; codel<start> c2(inout a, inout b) yield pause::start; };
       task t3 { period 5 ms; codel<start> c3(inout b) yield pause::start; }; };",
    // A permanent activity ends by itself, or fails, and has to stop.
    "component c { exception E { long code; };
       task t { period 5 ms; codel<start> c1() yield pause::main, ether;
         codel<main> c2() yield ether, pause::main; codel<stop> c3() yield ether; throw E; }; };",
    // An activity sleeps until an event, or goes on without pause beside one that pauses.
    "component c { event alarm; task t { period 5 ms; };
       activity go() { task t; codel<start> g1() yield sleep, pause::start, start;
         codel<alarm> g2() yield pause::start, pause::alarm; codel<stop> g3() yield ether; }; };",
    // Tasks without period wake each other; services have an order, and interrupt each other.
    "component c { ids { long a; }; task t { }; task u { };
       attribute set(in a);
       activity go() { task t; codel<start> g1() yield pause::start, ether; after set; };
       activity home() { task u; codel<start> h1() yield ether; before go; interrupts go; }; };",
];

/// The systems of these components.
pub(crate) fn systems() -> Vec<System> {
    let bounds = Bounds { slots: 1, ..Bounds::default() };
    let one = |text: &&str| small::system(text, bounds, text.contains("alarm"));
    COMPONENTS.iter().map(one).collect()
}

#[test]
fn each_changed_rule_is_noticed() {
    let models: Vec<_> = systems()
        .into_iter()
        .map(|system| {
            let text = written(&system);
            let told = told(&system, &text, 20_000).unwrap();
            (system, text, told)
        })
        .collect();
    let missed = CHANGES.iter().filter(|(_, from, to)| !is_noticed(&models, from, to));
    let missed: Vec<&str> = missed.map(|(rule, ..)| *rule).collect();
    assert!(missed.is_empty(), "not noticed: {missed:#?}");
}
