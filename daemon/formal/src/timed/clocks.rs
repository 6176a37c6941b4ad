//! The clocks of a state, and how a step changes them.

use super::times::Times;
use super::zone::Zone;
use crate::action::Action;
use crate::state::State;
use crate::system::System;

/// A clock of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Time since the last tick of a task.
    Tick(u16),
    /// Time since a context began to execute its node.
    Since(u16),
}

/// Nanoseconds as a bound of a zone.
pub(crate) fn bound(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX - 1)
}

/// The clocks of a state: of periodic tasks, then of contexts whose node has a bounded duration.
pub(crate) fn clocks(system: &System, times: &Times, state: &State) -> Vec<Clock> {
    let ticks = system.periods.iter().zip(0..).filter(|(period, _)| period.is_some());
    let held = state.lock.holders().filter(|(_, node)| {
        let duration = times.of(*node);
        duration.least > 0 || duration.most.is_some()
    });
    ticks
        .map(|(_, task)| Clock::Tick(task))
        .chain(held.map(|(context, _)| Clock::Since(context)))
        .collect()
}

/// Whether something is due at once, so that no time passes.
pub(crate) fn is_urgent(system: &System, state: &State) -> bool {
    !system.internal(state).is_empty()
}

/// The zone of the first state: the clocks of ticks are where the delays say.
pub(crate) fn initial(system: &System, times: &Times, state: &State) -> Option<Zone> {
    let since = |clock: &Clock| match clock {
        Clock::Tick(task) => {
            system.periods[usize::from(*task)].map_or(0, |p| bound((p.period - p.delay) % p.period))
        }
        Clock::Since(_) => 0,
    };
    let values: Vec<i64> = clocks(system, times, state).iter().map(since).collect();
    settle(system, times, state, Zone::point(&values))
}

/// The zone before a step, as far as the step is possible in it.
pub(crate) fn guarded(
    system: &System,
    times: &Times,
    state: &State,
    zone: &Zone,
    action: Action,
) -> Option<Zone> {
    let mut zone = zone.clone();
    let clocks = clocks(system, times, state);
    let place = |wanted: Clock| clocks.iter().position(|clock| *clock == wanted).map(|at| at + 1);
    let possible = match action {
        Action::Tick(task) => {
            let period = system.periods[usize::from(task)].map_or(0, |p| bound(p.period));
            place(Clock::Tick(task)).is_none_or(|clock| zone.at_least(clock, period))
        }
        Action::Return(context, _) => {
            let node = state.lock.held_by(context)?;
            let least = bound(times.of(node).least);
            place(Clock::Since(context)).is_none_or(|clock| zone.at_least(clock, least))
        }
        _ => true,
    };
    possible.then_some(zone)
}

/// The zone after a step from a zone in which it is possible.
pub(crate) fn stepped(
    system: &System,
    times: &Times,
    (from, zone): (&State, &Zone),
    action: Action,
    to: &State,
) -> Option<Zone> {
    let before = clocks(system, times, from);
    let source = |clock: &Clock| {
        let begins = begins(*clock, action);
        if begins { None } else { before.iter().position(|old| old == clock).map(|at| at + 1) }
    };
    let sources: Vec<Option<usize>> = clocks(system, times, to).iter().map(source).collect();
    settle(system, times, to, zone.select(&sources))
}

/// Whether a clock begins anew by a step, if it runs after it.
pub(crate) fn begins(clock: Clock, action: Action) -> bool {
    match (clock, action) {
        (Clock::Tick(task), Action::Tick(ticks)) => task == ticks,
        // What it executes now is another call.
        (Clock::Since(context), Action::Return(returned, _)) => context == returned,
        _ => false,
    }
}

/// The greatest value of a clock in a state.
pub(crate) fn greatest(system: &System, times: &Times, state: &State, clock: Clock) -> Option<u64> {
    match clock {
        Clock::Tick(task) => system.periods[usize::from(task)].map(|period| period.period),
        Clock::Since(context) => state.lock.held_by(context).and_then(|node| times.of(node).most),
    }
}

/// Lets time pass in a state, for as long as it may.
fn settle(system: &System, times: &Times, state: &State, mut zone: Zone) -> Option<Zone> {
    if !is_urgent(system, state) {
        zone.up();
    }
    for (clock, at) in clocks(system, times, state).iter().zip(1..) {
        if let Some(most) = greatest(system, times, state, *clock)
            && !zone.at_most(at, bound(most))
        {
            return None;
        }
    }
    Some(zone)
}
