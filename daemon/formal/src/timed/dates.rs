//! Dates of the steps of a run: the earliest that its bounds allow.

use super::clocks::is_urgent;
use super::times::Times;
use crate::action::Action;
use crate::state::State;
use crate::system::System;
use genom_timing::{AtLeast, Period, earliest};

/// The dates of the steps of a run, in nanoseconds from the start of the component.
pub(crate) fn dates(system: &System, times: &Times, run: &[(State, Action)]) -> Vec<u64> {
    dates_of(system, times, run, None, Vec::new())
}

/// The same, with more rules about the numbers of steps plus one; with a state in which time passes
/// after the last step, also the date up to which it does.
pub(crate) fn dates_of(
    system: &System,
    times: &Times,
    run: &[(State, Action)],
    waits: Option<&State>,
    mut more: Vec<AtLeast>,
) -> Vec<u64> {
    let steps = run.iter().map(|(state, action)| (state, Some(*action)));
    more.extend(rules(system, times, steps.chain(waits.map(|state| (state, None)))));
    let dates = earliest(run.len() + 1 + usize::from(waits.is_some()), &more);
    dates.into_iter().skip(1).map(|date| u64::try_from(date).unwrap_or(0)).collect()
}

/// Rules about the numbers of steps plus one; 0 is the start of the component.
fn rules<'s>(
    system: &System,
    times: &Times,
    run: impl Iterator<Item = (&'s State, Option<Action>)>,
) -> Vec<AtLeast> {
    let mut rules = Vec::new();
    let mut push = |later, earlier, by| rules.push(AtLeast { later, earlier, by });
    // When each context began what it executes, and the next tick of each task.
    let mut began: Vec<(u16, usize)> = Vec::new();
    let ticks = system
        .periods
        .iter()
        .zip(0..)
        .map(|(period, task)| period.filter(|_| system.ticks_of(task)).map(Period::first));
    let mut next: Vec<Option<u64>> = ticks.collect();
    for (at, (state, action)) in run.enumerate() {
        let (before, date) = (at, at + 1);
        push(date, before, 0);
        if is_urgent(system, state) {
            push(before, date, 0);
        }
        began.retain(|(context, _)| state.lock.held_by(*context).is_some());
        for (context, _) in state.lock.holders() {
            if !began.iter().any(|(known, _)| *known == context) {
                began.push((context, before));
            }
        }
        for tick in next.iter().flatten() {
            push(0, date, -ns(*tick));
        }
        for (context, since) in &began {
            let Some(node) = state.lock.held_by(*context) else { continue };
            let duration = times.of(node);
            if let Some(most) = duration.most {
                push(*since, date, -ns(most));
            }
            if matches!(action, Some(Action::Return(returned, _)) if returned == *context) {
                push(date, *since, ns(duration.least));
            }
        }
        match action {
            Some(Action::Return(returned, _)) => began.retain(|(context, _)| *context != returned),
            Some(Action::Tick(task)) => {
                let task = usize::from(task);
                if let (Some(tick), Some(period)) = (&mut next[task], system.periods[task]) {
                    push(date, 0, ns(*tick));
                    *tick += period.period;
                }
            }
            _ => {}
        }
    }
    rules
}

fn ns(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX)
}
