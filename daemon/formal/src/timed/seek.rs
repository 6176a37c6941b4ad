//! A search for a tick that comes while its task is at work: what may take longest is looked at first.
//!
//! Steps for which no time passes come at once: those of control and workers before all others, since
//! the runtime takes them by itself, and all of them before ticks of the same date. So the runtime
//! plays what is found; and what this leaves out differs in nothing but the order at one date.

use std::collections::BinaryHeap;
use std::time::Instant;

use super::clocks::{Clock, clocks, guarded, initial, is_urgent, stepped};
use super::explore::{Timed, works};
use super::potential::Potential;
use super::table::Table;
use super::times::Times;
use crate::action::Action;
use crate::explore::Limits;
use crate::state::State;
use crate::system::System;

/// A node that was found and not looked at: the longest cycle that may come of it, whether that
/// cycle goes on already, and its number, the last one first of equal ones.
type Open = (u64, bool, u32);

/// A run in which this task is late, if one is found within the limits.
pub(crate) fn seek(
    system: &System,
    times: &Times,
    limits: &Limits,
    potential: &Potential,
) -> Option<Vec<(State, Action)>> {
    let begin = Instant::now();
    let task = potential.task();
    let (mut table, mut open) = (Table::default(), BinaryHeap::<Open>::new());
    let first = system.initial(false);
    let zone = initial(system, times, &first)?;
    open.extend(table.add(&first, zone, (0, 0)).map(|number| (0, false, number)));
    let (mut looked, mut told, mut next) = (0, Vec::new(), first);
    while let Some((.., number)) = open.pop() {
        let Some((state, zone)) = table.get(number) else { continue };
        let zone = zone.clone();
        let before = clocks(system, times, &state);
        let steps = system.timed(&state);
        let (urgent, first) = (is_urgent(system, &state), steps.iter().any(is_first));
        for (action, step) in steps.iter().zip(0u16..) {
            if first && !is_first(action) || urgent && matches!(action, Action::Tick(_)) {
                continue;
            }
            let Some(possible) = guarded(system, times, (&state, &before), &zone, *action) else {
                continue;
            };
            if Timed::is_late(&state, *action) == Some(task) {
                return Some(table.run_to(system, (number, *action)));
            }
            system.after_into(&mut next, &state, *action, &mut told);
            told.clear();
            let after: Vec<Clock> = clocks(system, times, &next);
            let from = (&before[..], &*possible);
            let Some(zone) = stepped(system, times, from, *action, (&next, &after)) else {
                continue;
            };
            let most = potential.of(system, times, &next, (&after, &zone));
            let goes_on = works(&next, usize::from(task));
            let added = table.add(&next, zone, (number, step));
            open.extend(added.map(|number| (most, goes_on, number)));
        }
        looked += 1;
        if limits.passed(table.len(), table.bytes, looked, begin).is_some() {
            return None;
        }
    }
    None
}

/// Whether no script says when this happens: it does as soon as it can.
fn is_first(action: &Action) -> bool {
    matches!(action, Action::Start | Action::Advance | Action::Wake(_) | Action::Proceed(_))
}
