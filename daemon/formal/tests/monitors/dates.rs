//! The dates of runs that break rules on time: the earliest at which they can. In nanoseconds.

use genom_formal::Times;
use serde_json::json;

use super::between::PAIR;
use super::times::{PACED, takes};
use super::{ARM, dated_with};

/// The run has these lines at these dates, the last one at its end.
#[track_caller]
fn dated_at(text: &str, rule: serde_json::Value, set: impl Fn(&mut Times), told: &[(u64, &str)]) {
    let (_, run) = dated_with(text, rule, set);
    let run: Vec<(u64, &str)> =
        run.iter().map(|(date, line)| (date.unwrap(), line.as_str())).collect();
    let mut left = run.iter();
    for line in told {
        assert!(left.any(|other| other == line), "{line:?}: {run:#?}");
    }
    assert_eq!(run.last(), told.last(), "{run:#?}");
}

#[track_caller]
fn dated(text: &str, rule: serde_json::Value, told: &[(u64, &str)]) {
    dated_at(text, rule, |_| {}, told);
}

#[test]
fn a_formula_is_broken_as_soon_as_its_bounds_allow() {
    // `move` is called at the tick after that of `plan`, and has to take longer than 2 ms.
    dated(
        ARM,
        json!({"formula": "pose -> once[0, 2ms] move"}),
        &[
            (10_000_000, "t: goto: plan begins"),
            (20_000_000, "t: goto: move begins"),
            (22_000_001, "t: goto: move yields ether"),
        ],
    );
    // The first call of `second` that breaks it is at 30 ms, 29 ms after the first return.
    let late = json!({"formula": "second -> not once[10001us, 29ms] return(first)"});
    dated(
        PAIR,
        late,
        &[
            (1_000_000, "ten: first yields pause::second"),
            (20_000_000, "ten: first begins"),
            (30_000_000, "ten: second begins"),
        ],
    );
    // Ago by more than 9999 us: it returned by 1 us after its call. As late as that it need not be.
    let soon = json!({"formula": "second -> once[9ms, 9999us] return(first)"});
    dated(
        PAIR,
        soon,
        &[(0, "ten: first yields pause::second"), (10_000_000, "ten: second begins")],
    );
    // By less than 9001 us: not sooner than 999001 ns after its call.
    let late = json!({"formula": "second -> once[9001us, 10ms] return(first)"});
    dated(
        PAIR,
        late,
        &[(999_001, "ten: first yields pause::second"), (10_000_000, "ten: second begins")],
    );
    // `clear` is called by a request: at most 15 ms before the tick at which `move` is.
    let request = json!({"formula": "move -> not once[12ms, 15ms] clear"});
    dated(
        ARM,
        request,
        &[(5_000_000, "reset: clear begins"), (20_000_000, "t: goto: move begins")],
    );
}

#[test]
fn a_limit_on_an_activity_is_passed_one_step_of_the_clock_after_it() {
    // Accepted at 10 ms; `go` takes 4 ms at most, so it begins no sooner than 22.900001 ms.
    dated(
        PACED,
        json!({"activity": "once", "longest_ms": 16.9}),
        &[
            (10_000_000, "once: is accepted"),
            (20_000_000, "ten: loops: halt begins"),
            (22_900_001, "ten: once: go begins"),
            (26_900_001, "rule: is broken"),
        ],
    );
    // Asked at 10 ms, it is at `halt` from the next tick on.
    dated(
        ARM,
        json!({"activity": "goto", "longest_stop_ms": 10.9}),
        &[
            (10_000_000, "client: aborts goto"),
            (20_000_000, "t: goto: halt begins"),
            (20_900_001, "rule: is broken"),
        ],
    );
    // With a codel that always takes 3 ms.
    let rule = json!({"activity": "loops", "longest_stop_ms": 2});
    dated_at(
        PACED,
        rule,
        takes(PACED, "halt", 3, Some(3)),
        &[(10_000_000, "client: aborts loops"), (12_000_001, "rule: is broken")],
    );
}

#[test]
fn cycles_heartbeats_and_missed_ticks_have_dates() {
    dated(
        ARM,
        json!({"task": "t", "longest_ms": 2}),
        &[(20_000_000, "t: goto: move begins"), (22_000_001, "rule: is broken")],
    );
    // The last call of `plan` or `move` was at 10 ms, where the activity began.
    dated(
        ARM,
        json!({"codel": "move", "every_ms": [10, 10.5]}),
        &[(10_000_000, "t: goto: plan begins"), (20_500_001, "rule: is broken")],
    );
    // It is called at each tick, first at the start.
    dated(
        PACED,
        json!({"codel": "tick", "every_ms": [6, 8]}),
        &[(0, "five: tick begins"), (5_000_000, "five: tick begins")],
    );
    // Nobody waits for it before the start-up is over: the call tells that it was late.
    dated(
        PACED,
        json!({"codel": "tick", "every_ms": [1, 4]}),
        &[(0, "five: tick begins"), (5_000_000, "five: tick begins")],
    );
    // `big` takes longer than a period at 0 and at 40 ms.
    dated(
        PACED,
        json!({"task": "four", "missed": 2, "within_ms": 40}),
        &[
            (10_000_000, "four: tick"),
            (10_000_000, "four: big yields pause::a"),
            (40_000_000, "four: big begins"),
            (50_000_000, "four: tick"),
        ],
    );
}

#[test]
fn what_is_found_without_times_has_no_dates() {
    for rule in [
        json!({"formula": "move -> once[0, 2s] clear"}),
        json!({"service": "reset", "after": "calibrate"}),
        json!({"codel": "move", "longest_ms": 2}),
    ] {
        let (verdict, run) = dated_with(ARM, rule, |_| {});
        assert!(verdict.starts_with("can: ") && !run.is_empty(), "{verdict}");
        assert!(run.iter().all(|(date, _)| date.is_none()), "{run:#?}");
    }
}
