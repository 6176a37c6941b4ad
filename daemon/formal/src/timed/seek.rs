//! A search for a tick that comes while its task is at work: of what may take longest, and of what has
//! come farthest in a cycle that may be late, in turn. The codels of the task take their longest times.
//! Steps for which no time passes come at once: those of control and workers before all others, since
//! the runtime takes them by itself, and all of them before ticks of the same date. So the runtime
//! plays what is found; and what this leaves out differs in nothing but the order at one date.

use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::clocks::{Clock, clocks, guarded, initial, is_urgent, stepped};
use super::dates::dates;
use super::explore::{Timed, works};
use super::potential::Potential;
use super::table::Table;
use crate::action::Action;
use crate::state::{Phase, State};
use crate::system::System;
use genom_timing::Limits;

/// Each state of a run, and the step that leaves it.
pub(crate) type Steps = Vec<(State, Action)>;

/// Nodes that were found and not looked at, with what comes first of them; the last one of equal ones.
type Open = BinaryHeap<((u64, u64), u32)>;

/// A run in which this task is late, if one is found within the limits.
pub(crate) fn seek(limits: &Limits, potential: &Potential<'_>, over: &AtomicBool) -> Option<Steps> {
    let begin = Instant::now();
    let Potential { system, task, .. } = *potential;
    let times = &potential.times.longest_of(system, task);
    let (mut table, mut open) = (Table::default(), [Open::new(), Open::new()]);
    let first = system.initial(false);
    let zone = initial(system, times, &first)?;
    open[0].extend(table.add(&first, zone, (0, 0)).map(|number| ((0, 0), number)));
    let (mut looked, mut told, mut next, mut done) = (0, Vec::new(), first, Vec::new());
    let mut turns = [0, 1].into_iter().cycle();
    while let Some((_, number)) = turns.by_ref().take(2).find_map(|at| open[at].pop()) {
        done.resize(table.len(), false);
        if std::mem::replace(&mut done[number as usize], true) {
            continue;
        }
        let Some((state, zone)) = table.get(number) else { continue };
        let zone = zone.clone();
        let before = clocks(system, times, &state);
        for (action, step) in possible(system, &state) {
            let Some(possible) = guarded(system, times, (&state, &before), &zone, action) else {
                continue;
            };
            if Timed::is_late(&state, action) == Some(task) {
                let run = table.run_to(system, (number, action));
                if is_played(potential, &run) {
                    return Some(run);
                }
            }
            system.after_into(&mut next, &state, action, &mut told);
            told.clear();
            let after: Vec<Clock> = clocks(system, times, &next);
            let from = (&before[..], &*possible);
            let Some(zone) = stepped(system, times, from, action, (&next, &after)) else {
                continue;
            };
            let most = potential.of(&next, (&after, &zone));
            let goes_on = u64::from(works(&next, usize::from(task)));
            let progress = potential.progress(&next, (&after, &zone));
            let Some(number) = table.add(&next, zone, (number, step)) else { continue };
            open[0].push(((most, goes_on), number));
            let may_be_late = most >= potential.period;
            let far = if may_be_late { progress } else { u64::from(u32::MAX - number) };
            open[1].push(((u64::from(may_be_late), far), number));
        }
        looked += 1;
        let passed = limits.passed(table.len(), table.bytes(), looked, begin).is_some();
        if passed || over.load(Ordering::Relaxed) {
            return None;
        }
    }
    None
}

/// The steps that are looked at in a state, with their numbers among all.
pub(super) fn possible(system: &System, state: &State) -> Vec<(Action, u16)> {
    let all = system.timed(state);
    let (urgent, first) = (is_urgent(system, state), all.iter().any(is_first));
    let later =
        |action: &Action| first && !is_first(action) || urgent && matches!(action, Action::Tick(_));
    all.into_iter().zip(0u16..).filter(|(action, _)| !later(action)).collect()
}

/// Whether no script says when this happens: it does as soon as it can.
pub(super) fn is_first(action: &Action) -> bool {
    matches!(action, Action::Start | Action::Advance | Action::Wake(_) | Action::Proceed(_))
}

/// Whether the runtime plays this: it does not keep a tick at the very date at which its task starts.
pub(super) fn is_played(potential: &Potential<'_>, run: &[(State, Action)]) -> bool {
    let dates = dates(potential.system, potential.times, run);
    let steps = || run.iter().zip(&dates);
    let ticks =
        |task, date| steps().any(|((_, one), tick)| *one == Action::Tick(task) && tick == date);
    !steps().any(|((state, action), date)| {
        let Phase::Starting(task) = state.phase else { return false };
        *action == Action::Start && ticks(task, date)
    })
}
