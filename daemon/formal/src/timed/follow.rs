//! One activity at a time that is followed: from its acceptance, or from when it was asked to stop,
//! until it is over. It is told from others by its number; all others have none.

use crate::action::{Action, Told};
use crate::rules::runs_of;
use crate::state::{Life, Pc, State};
use crate::system::System;

/// The number of an activity that is followed from its acceptance on.
const ACCEPTED: u32 = 1;
/// And of one that is followed from when it was asked to stop.
const ASKED: u32 = 2;

/// Which activity is followed from a step on.
#[derive(Clone, Copy)]
pub(crate) enum Follow {
    /// No other than before.
    None,
    /// The one that is accepted.
    Accepted,
    /// The one at this place of a task, if it is asked to stop.
    Asked(usize, usize),
}

/// Which activity may be followed from a step on: none if one is already.
pub(crate) fn choices(system: &System, state: &State, action: Action) -> Vec<Follow> {
    let mut all = vec![Follow::None];
    if number(state).is_some() {
        return all;
    }
    if accepts(system, state, action).is_some() {
        all.push(Follow::Accepted);
    }
    if matches!(action, Action::Proceed(_) | Action::Abort(..) | Action::Collect(_)) {
        all.extend(running(system, state).map(|(follow, _)| follow));
    }
    all
}

/// The service of which a step accepts an activity.
pub(crate) fn accepts(system: &System, state: &State, action: Action) -> Option<u16> {
    let Action::Proceed(service) = action else { return None };
    let accepts = system.pc(state, service) == Some(Pc::Conclude)
        && system.services[usize::from(service)].machine.is_some();
    accepts.then_some(service)
}

/// Activities that run and were not asked to stop, with their services.
pub(crate) fn running<'a>(
    system: &'a System,
    state: &'a State,
) -> impl Iterator<Item = (Follow, u16)> + 'a {
    state.tasks.iter().enumerate().flat_map(move |(at, task)| {
        let runs = task.runs.iter().enumerate();
        let runs = runs.filter(|(_, run)| run.life == Life::Run && !run.asked);
        runs.filter_map(move |(run, of)| Some((Follow::Asked(at, run), system.service_of(of)?)))
    })
}

/// The state after a step, with the number of the activity that is followed.
pub(crate) fn after_into(
    system: &System,
    (next, state): (&mut State, &State),
    action: Action,
    follow: Follow,
    told: &mut Vec<Told>,
) {
    match follow {
        Follow::None => system.after_into(next, state, action, told),
        Follow::Accepted => {
            let state = State { next: ACCEPTED, ..state.clone() };
            system.after_into(next, &state, action, told);
            next.next = 0;
        }
        Follow::Asked(task, run) => {
            system.after_into(next, state, action, told);
            if let Some(run) = next.tasks[task].runs.get_mut(run).filter(|run| run.asked) {
                run.number = ASKED;
            }
        }
    }
}

/// The number of the activity that is followed.
pub(crate) fn number(state: &State) -> Option<u32> {
    let pending = state.pending.iter().map(|pending| pending.number);
    let runs = state.tasks.iter().flat_map(runs_of).map(|run| run.number);
    pending.chain(runs).find(|number| *number != 0)
}

/// How what is followed is over.
pub(crate) enum Over {
    Begun,
    Ended,
    Gone,
}

/// The service of which an activity need not be followed any more.
pub(crate) fn over(
    system: &System,
    state: &State,
    next: &State,
    told: &[Told],
) -> Option<(u16, Over)> {
    let number = number(state)?;
    let mut runs = state.tasks.iter().flat_map(runs_of);
    let service = match runs.find(|run| run.number == number) {
        Some(run) => system.service_of(run)?,
        None => state.pending.iter().find(|pending| pending.number == number)?.service,
    };
    if told.iter().any(|told| matches!(told, Told::Ended(ended, _) if *ended == number)) {
        return Some((service, if number == ASKED { Over::Ended } else { Over::Gone }));
    }
    let mut runs = next.tasks.iter().flat_map(runs_of);
    let begun = runs.any(|run| run.number == number && run.life == Life::Run);
    (number == ACCEPTED && begun).then_some((service, Over::Begun))
}

/// From here on no activity is followed.
pub(crate) fn forget(state: &mut State) {
    for task in &mut state.tasks {
        let runs = task.runs.iter_mut().chain(&mut task.inbox).chain(&mut task.outbox);
        runs.for_each(|run| run.number = 0);
    }
    state.pending.iter_mut().for_each(|pending| pending.number = 0);
}
