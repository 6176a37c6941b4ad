//! Models for other tools name only what they declare. What they say is compared with Spin
//! (`spin`); TChecker and UPPAAL are no part of the tests.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::collections::BTreeSet;

use genom_formal::{ExportError, Format, Limits};
use support::{DUO, limits, running};

/// Their ticks are not at the same dates.
fn shifted() -> String {
    DUO.replace("period 10 ms;", "period 10 ms; delay 4 ms;")
}

/// What stands between `from` and the next of these characters.
fn after<'a>(text: &'a str, from: &str, ends: &[char]) -> Vec<&'a str> {
    text.split(from).skip(1).filter_map(|rest| rest.split(ends).next()).collect()
}

#[test]
fn tchecker_gets_all_states_and_each_step_leads_to_one() {
    let system = running(&shifted());
    let times = system.declared_times();
    let text = system.export(Format::Tchecker, Some(&times), &limits()).unwrap();
    let declared: BTreeSet<&str> = after(&text, "\nlocation:p:", &['{']).into_iter().collect();
    let states = system.check_times(&times, &limits()).explored.states();
    let found = declared.iter().filter(|name| name.starts_with('s')).count();
    assert_eq!(found, states);
    for edge in after(&text, "\nedge:p:", &['{']) {
        let ends: Vec<&str> = edge.split(':').take(2).collect();
        assert!(ends.iter().all(|end| declared.contains(end)), "{edge}");
    }
    // At the start `fast` is 6 ms after a tick: its first one comes at 4 ms.
    assert!(text.contains("location:p:b0{initial: : invariant: t0<=6}"), "{text}");
    assert!(text.contains("labels: late_fast"), "{text}");
}

#[test]
fn uppaal_gets_the_same_states_and_steps() {
    let system = running(&shifted());
    let times = system.declared_times();
    let flat = system.export(Format::Tchecker, Some(&times), &limits()).unwrap();
    let text = system.export(Format::Uppaal, Some(&times), &limits()).unwrap();
    let ids: BTreeSet<&str> = after(&text, "<location id=\"", &['"']).into_iter().collect();
    assert_eq!(ids.len(), after(&flat, "\nlocation:p:", &['{']).len());
    let refs = after(&text, " ref=\"", &['"']);
    assert!(refs.iter().all(|one| ids.contains(one)));
    assert_eq!(
        after(&text, "<transition>", &['\n']).len(),
        after(&flat, "\nedge:p:", &['{']).len()
    );
    assert!(text.contains("<formula>A[] not c.late_fast</formula>"), "{text}");
}

#[test]
fn clocks_want_times_of_all_codels() {
    let system = running(&shifted().replace("wcet 8 ms", ""));
    assert_eq!(system.export(Format::Tchecker, None, &limits()), Err(ExportError::NoTimes));
    let few = Limits { states: 3, ..limits() };
    let times = system.declared_times();
    let refused = system.export(Format::Uppaal, Some(&times), &few).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the states cannot be written out: more than 3 states; lower the bounds on clients"
    );
}
