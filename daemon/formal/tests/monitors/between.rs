//! Formulas with bounds of which neither side is open, for which more than one date counts.

use serde_json::json;

use super::{ARM, fires_in};

/// `first` is called at 0, 20, 40 ms, and returns within 1 ms; `second` is called at 10, 30, 50 ms.
pub(super) const PAIR: &str = "component pair {
  task ten { period 10 ms;
    codel<start> first() yield pause::second wcet 1 ms;
    codel<second> second() yield pause::start wcet 1 ms; };
};";

#[track_caller]
fn check(text: &str, formula: &str, told: &str) {
    let (verdict, run) = fires_in(text, json!({ "formula": formula }));
    assert_eq!(verdict, told, "{formula}: {run:#?}");
}

#[track_caller]
fn never(formula: &str) {
    check(PAIR, formula, "never");
}

#[track_caller]
fn can(formula: &str) {
    check(PAIR, formula, "can: codel second was called");
}

#[test]
fn bounds_of_calls_at_known_dates_include_both_sides() {
    never("second -> once[10ms, 11ms] first");
    never("second -> once[9ms, 10ms] first");
    can("second -> once[10001us, 29999us] first");
    // Calls were 10 ms ago and, but for the first time, 30 ms ago: of one date that is the last or
    // the first, these would be told wrong.
    never("second -> not once[10001us, 29999us] first");
    can("second -> not once[10001us, 30ms] first");
    can("second -> not once[30ms, 31ms] first");
    never("second -> not once[30001us, 49999us] first");
    can("second -> not once[30001us, 50ms] first");
    never("second and previous once second -> once[30ms, 35ms] first");
    never("second and previous once second -> once[25ms, 30ms] first");
    can("second and previous once second -> once[30001us, 35ms] first");
}

#[test]
fn bounds_of_returns_within_a_time_include_both_sides_of_it() {
    never("second -> once[9ms, 10ms] return(first)");
    can("second -> once[9001us, 10ms] return(first)");
    can("second -> once[9ms, 9999us] return(first)");
    never("second -> not once[10001us, 28999us] return(first)");
    can("second -> not once[10001us, 29ms] return(first)");
    never("second -> not once[30001us, 48999us] return(first)");
    can("second -> not once[30001us, 49ms] return(first)");
}

#[test]
fn what_held_all_the_time_and_since_may_have_two_bounds() {
    can("second -> historically[29ms, 31ms] not first");
    never("second -> historically[11ms, 29ms] not first");
    // The last call of `second` ends it: only the call of `first` 10 ms ago is left.
    never("second -> not (not previous second since[20ms, 35ms] first)");
    can("second -> not (not previous second since[10ms, 35ms] first)");
    never("second -> (true since[10ms, 35ms] first)");
}

#[test]
fn requests_may_come_at_any_date() {
    check(ARM, "move -> not once[12ms, 15ms] clear", "can: codel move was called");
    check(ARM, "move -> once[10ms, 12ms] clear", "can: codel move was called");
    check(ARM, "move -> not once[30ms, 60ms] clear", "can: codel move was called");
    check(ARM, "move -> not once[60ms, 90ms] clear", "can: codel move was called");
}

#[test]
fn where_too_many_dates_count_it_is_not_decided() {
    let often = PAIR.replace("10 ms", "1 ms");
    let (verdict, _) = fires_in(
        &often,
        json!({ "formula": "second and once[40ms, inf] first -> once[30ms, 31ms] first" }),
    );
    assert!(verdict.starts_with("undecided: more than 12 dates count at a time"), "{verdict}");
}
