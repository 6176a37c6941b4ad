//! Why an earlier prototype of these rules counts other states and zones of two tasks that share data
//! (`docs/verify.md`): it takes what is due at once before all other steps of that date, keeps zones
//! as they are, and has no ticks in the start-up. With the first two of these, the states in which
//! requests are served are as many as its own.

#![allow(clippy::unwrap_used)]

use std::collections::HashMap;
use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_runtime::Plan;

use super::clocks::{Clock, carried, clocks, guarded, is_urgent, passed};
use super::times::{Duration, Times};
use crate::action::Action;
use crate::bounds::Bounds;
use crate::state::{Phase, State};
use crate::system::System;
use genom_timing::Zone;

const MS: u64 = 1_000_000;

/// The two tasks, if each codel takes at least a millisecond and `sb` at most so many.
fn duo(most: u64) -> (System, Times) {
    let text = "component duo { ids { long shared; };
      task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start; };
      task slow { period 40 ms; codel<start> sb(inout shared) yield work;
        codel<work> sw() yield pause::start; }; };";
    let options = Options { standard_interface: false, ..Options::default() };
    let specification = read_text("duo.gen", text, &options).specification;
    let plan = Arc::new(Plan::new(&Arc::new(specification), 0).unwrap());
    let system = System::new(&plan, Bounds { kill: false, ..Bounds::default() });
    let mut times = system.declared_times();
    for (codel, most) in [("fa", 3), ("sb", most), ("sw", 20)] {
        let duration = Duration { least: MS, most: Some(most * MS) };
        assert!(times.set(plan.component(), codel, duration));
    }
    (system, times)
}

/// What the prototype does in another way.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    /// What is due at once comes before all other steps of that date.
    due_first: bool,
    /// Zones have the values that clocks can have, and no others.
    exact: bool,
    /// No tick comes before all tasks have ended their first cycles.
    quiet_start: bool,
}

/// States and their zones: of the start-up, and after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counts {
    start: (usize, usize),
    served: (usize, usize),
}

/// Whether a state is one of the start-up, or of a cycle that it began.
fn starts(state: &State) -> bool {
    state.phase != Phase::Running || state.tasks.iter().any(|task| task.young > 0)
}

fn explored((system, times): &(System, Times), how: Differences) -> Counts {
    let settled = |state: &State, clocks: &[Clock], zone: Zone| {
        let (mut zone, guards) = passed(system, times, (state, clocks), zone)?;
        if !how.exact {
            zone.extrapolate(&guards);
        }
        Some(zone)
    };
    let first = system.initial(false);
    let clocks_of_first = clocks(system, times, &first);
    let zero = Zone::point(&vec![0; clocks_of_first.len()]);
    let zone = settled(&first, &clocks_of_first, zero).unwrap();
    let mut all: HashMap<State, Vec<Zone>> = HashMap::new();
    all.insert(first.clone(), vec![zone.clone()]);
    let mut open = vec![(first, zone)];
    while let Some((state, zone)) = open.pop() {
        if !all[&state].contains(&zone) {
            // Another one has all its values by now.
            continue;
        }
        let before = clocks(system, times, &state);
        let due = how.due_first && is_urgent(system, &state);
        let steps = if due { system.internal(&state) } else { system.timed(&state) };
        for action in steps {
            if how.quiet_start && starts(&state) && matches!(action, Action::Tick(_)) {
                continue;
            }
            let Some(possible) = guarded(system, times, (&state, &before), &zone, action) else {
                continue;
            };
            let next = system.after(&state, action, &mut Vec::new());
            let after = clocks(system, times, &next);
            let zone = carried((&before, &possible), action, &after);
            let Some(zone) = settled(&next, &after, zone) else { continue };
            let known = all.entry(next.clone()).or_default();
            if !known.iter().any(|other| other.includes(&zone)) {
                known.retain(|other| !zone.includes(other));
                known.push(zone.clone());
                open.push((next, zone));
            }
        }
    }
    let count = |of_start: bool| {
        let own = all.iter().filter(|(state, _)| starts(state) == of_start);
        own.fold((0, 0), |(states, zones), (_, own)| (states + 1, zones + own.len()))
    };
    Counts { start: count(true), served: count(false) }
}

#[test]
fn golden_numbers_differ_by_what_is_due_at_once_by_wider_zones_and_by_the_start_up() {
    let count = |most: u64, due_first: bool, exact: bool, quiet_start: bool| {
        let counts = explored(&duo(most), Differences { due_first, exact, quiet_start });
        (counts.start, counts.served)
    };
    // As it is explored: the numbers of `tests/times.rs`, of the start-up and of what follows it.
    assert_eq!(count(6, false, false, false), ((13, 17), (28 - 13, 51 - 17)));
    assert_eq!(count(8, false, false, false), ((21, 30), (39 - 21, 76 - 30)));
    // One difference after the other.
    assert_eq!(count(6, true, false, false).1, (14, 33));
    assert_eq!(count(8, true, false, false).1, (16, 44));
    assert_eq!(count(6, true, true, false), ((13, 17), (14, 37)));
    assert_eq!(count(8, true, true, false), ((18, 30), (16, 52)));
    // The prototype has 20 states with 43 zones, and 22 with 58; six of the start-up, with a zone each.
    assert_eq!(count(6, true, true, true).1, (20 - 6, 43 - 6));
    assert_eq!(count(8, true, true, true).1, (22 - 6, 58 - 6));
}
