//! The clocks of a state, and how a step changes them.

use std::borrow::Cow;

use super::times::Times;
use crate::action::Action;
use crate::codels::small;
use crate::state::State;
use crate::system::System;
use genom_timing::{Guards, Zone};

/// A clock of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Time since the last tick of a task.
    Tick(u16),
    /// Time since a context began to execute its node.
    Since(u16),
    /// Time since an activity is followed, of interest up to this many nanoseconds.
    Followed(u64),
    /// Time since a date that is noted for a formula, by its number among those that are; compared
    /// with no more nanoseconds than this.
    Noted(u16, u64),
}

/// Nanoseconds as a bound of a zone.
pub(crate) fn bound(ns: u64) -> i64 {
    i64::try_from(ns).unwrap_or(i64::MAX - 1)
}

/// The clocks of a state: of periodic tasks, then of contexts whose node has a bounded duration.
pub(crate) fn clocks(system: &System, times: &Times, state: &State) -> Vec<Clock> {
    let ticks = (0..small(system.periods.len())).filter(|task| system.ticks_of(*task));
    let held = state.lock.holders().filter(|(_, node)| {
        let duration = times.of(*node);
        duration.least > 0 || duration.most.is_some()
    });
    ticks.map(Clock::Tick).chain(held.map(|(context, _)| Clock::Since(context))).collect()
}

/// Whether something is due at once, so that no time passes.
pub(crate) fn is_urgent(system: &System, state: &State) -> bool {
    system.any_internal(state, &mut |_| true)
}

/// The zone of the first state: the clocks of ticks are where the delays say.
pub(crate) fn initial(system: &System, times: &Times, state: &State) -> Option<Zone> {
    let since = |clock: &Clock| match clock {
        Clock::Tick(task) => {
            system.periods[usize::from(*task)].map_or(0, |period| bound(period.before_start()))
        }
        Clock::Since(_) | Clock::Followed(_) | Clock::Noted(..) => 0,
    };
    let clocks = clocks(system, times, state);
    let values: Vec<i64> = clocks.iter().map(since).collect();
    settle(system, times, (state, &clocks), Zone::point(&values))
}

/// The zone before a step, as far as the step is possible in it.
pub(crate) fn guarded<'z>(
    system: &System,
    times: &Times,
    (state, clocks): (&State, &[Clock]),
    zone: &'z Zone,
    action: Action,
) -> Option<Cow<'z, Zone>> {
    let (clock, least) = match action {
        Action::Tick(task) => {
            let period = system.periods[usize::from(task)].map_or(0, |p| bound(p.period));
            (Clock::Tick(task), period)
        }
        Action::Return(context, _) => {
            let node = state.lock.held_by(context)?;
            (Clock::Since(context), bound(times.of(node).least))
        }
        _ => return Some(Cow::Borrowed(zone)),
    };
    let Some(at) = clocks.iter().position(|known| *known == clock).filter(|_| least > 0) else {
        return Some(Cow::Borrowed(zone));
    };
    if zone.most(at + 1).is_some_and(|most| most < least) {
        return None;
    }
    let mut zone = zone.clone();
    zone.at_least(at + 1, least).then_some(Cow::Owned(zone))
}

/// The zone after a step from a zone in which it is possible.
pub(crate) fn stepped(
    system: &System,
    times: &Times,
    (before, zone): (&[Clock], &Zone),
    action: Action,
    (to, after): (&State, &[Clock]),
) -> Option<Zone> {
    settle(system, times, (to, after), carried((before, zone), action, after))
}

/// The values of the clocks after a step, before time passes.
pub(super) fn carried((before, zone): (&[Clock], &Zone), action: Action, after: &[Clock]) -> Zone {
    let source = |clock: &Clock| {
        let begins = begins(*clock, action);
        if begins { None } else { before.iter().position(|old| old == clock).map(|at| at + 1) }
    };
    let sources: Vec<Option<usize>> = after.iter().map(source).collect();
    zone.select(&sources)
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
        Clock::Followed(_) | Clock::Noted(..) => None,
    }
}

/// Lets time pass in a state, for as long as it may.
fn settle(system: &System, times: &Times, to: (&State, &[Clock]), zone: Zone) -> Option<Zone> {
    let (mut zone, guards) = passed(system, times, to, zone)?;
    zone.extrapolate(&guards);
    Some(zone)
}

/// The same, with what later steps compare the clocks with.
pub(super) fn passed(
    system: &System,
    times: &Times,
    (state, clocks): (&State, &[Clock]),
    mut zone: Zone,
) -> Option<(Zone, Vec<Guards>)> {
    if !is_urgent(system, state) {
        zone.up();
    }
    let mut guards = Vec::with_capacity(clocks.len());
    for (clock, at) in clocks.iter().zip(1..) {
        let most = greatest(system, times, state, *clock).map(bound);
        if most.is_some_and(|most| !zone.at_most(at, most)) {
            return None;
        }
        let least = match clock {
            Clock::Tick(_) => most,
            Clock::Since(context) => {
                let node = state.lock.held_by(*context);
                node.map(|node| bound(times.of(node).least)).filter(|least| *least > 0)
            }
            Clock::Followed(most) | Clock::Noted(_, most) => Some(bound(*most)),
        };
        let passes = matches!(clock, Clock::Noted(..));
        guards.push(Guards { least, most: if passes { least } else { most }, passes });
    }
    Some((zone, guards))
}
