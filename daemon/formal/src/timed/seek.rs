//! A search for a tick that comes while its task is at work: what may take longest is looked at first.

use std::collections::BinaryHeap;
use std::time::Instant;

use super::clocks::{Clock, clocks, guarded, initial, stepped};
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
    let (mut looked, mut told) = (0, Vec::new());
    while let Some((.., number)) = open.pop() {
        let Some((state, zone)) = table.get(number) else { continue };
        let zone = zone.clone();
        let before = clocks(system, times, &state);
        for (action, step) in system.timed(&state).iter().zip(0u16..) {
            let Some(possible) = guarded(system, times, (&state, &before), &zone, *action) else {
                continue;
            };
            if Timed::is_late(&state, *action) == Some(task) {
                return Some(table.run_to(system, (number, *action)));
            }
            let next = system.after(&state, *action, &mut told);
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
