//! Formulas of users as claims: which there are, and why others are none.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../formal/tests/support/mod.rs"]
mod support;

use genom_export::{ExportError, export_claim};
use genom_formal::{Bounds, Formula, System};
use support::system;

const TEXT: &str = "component c {
  task t { period 10 ms; codel<start> t0() yield ether; };
  activity go() { task t; codel<start> g0() yield ether; };
  activity home() { task t; codel<start> h0() yield ether; after go; };
};";

fn component() -> System {
    system(TEXT, Bounds::default(), true)
}

#[test]
fn chains_as_long_as_a_formula_may_be_are_written() {
    let system = component();
    for operator in ["&&", "||", "<->"] {
        let text = format!("[] ({})", ["go"; 390].join(operator));
        let formula = Formula::new(&system, &text).unwrap();
        assert!(export_claim(&system, &formula, None).is_ok(), "{operator}");
    }
}

#[test]
fn what_a_claim_cannot_say_is_told() {
    let system = component();
    let claim = |text: &str| export_claim(&system, &Formula::new(&system, text).unwrap(), None);
    assert_eq!(claim("[] !late(t)"), Err(ExportError::NoTimes));
    assert_eq!(claim("[] (go -> <> once home)"), Err(ExportError::Past));
}
