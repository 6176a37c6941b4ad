//! One request at a time that is followed until its answer: an activity keeps a number.

use super::graph::ends_from;
use crate::action::{Action, Answer, Told};
use crate::machines::Machine;
use crate::state::{Life, Mode, Pc, Run, State};
use crate::system::System;

/// The number of the activity that is followed.
const FOLLOWED: u32 = 1;

/// A step, and whether the activity that it accepts is followed.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) action: Action,
    pub(super) follow: bool,
}

/// The steps of a state. An accepted activity is followed or not.
pub(super) fn steps(system: &System, state: &State) -> Vec<Step> {
    let mut steps = Vec::new();
    for action in system.enabled(state) {
        steps.push(Step { action, follow: false });
        if let Action::Proceed(service) = action
            && system.pc(state, service) == Some(Pc::Conclude)
            && system.services[usize::from(service)].machine.is_some()
            && followed(state).is_none()
        {
            steps.push(Step { action, follow: true });
        }
    }
    steps
}

/// The state after a step, into the memory of another one; without a number once the activity has
/// ended.
pub(super) fn after_into(
    system: &System,
    next: &mut State,
    state: &State,
    step: Step,
    told: &mut Vec<Told>,
) {
    if step.follow {
        let state = State { next: FOLLOWED, ..state.clone() };
        system.after_into(next, &state, step.action, told);
        next.next = 0;
    } else {
        system.after_into(next, state, step.action, told);
    }
    if told.iter().any(is_answer) {
        for task in &mut next.tasks {
            let runs = task.runs.iter_mut().chain(&mut task.inbox).chain(&mut task.outbox);
            runs.for_each(|run| run.number = 0);
        }
        next.pending.iter_mut().for_each(|pending| pending.number = 0);
    }
}

pub(super) fn is_answer(told: &Told) -> bool {
    matches!(told, Told::Ended(FOLLOWED, _))
}

/// Whether a step needs nobody to ask for it, and no codel to fail.
pub(super) fn is_by_itself(system: &System, action: Action) -> bool {
    match action {
        Action::Return(context, Answer::Fail) => !system.is_task(context),
        Action::Request(_) | Action::Abort(..) | Action::Fire(..) | Action::Kill => false,
        _ => true,
    }
}

/// The activity that is followed, if it is not pending.
fn run_of(state: &State) -> Option<&Run> {
    let tasks = state.tasks.iter();
    let mut runs = tasks.flat_map(|task| task.runs.iter().chain(&task.inbox).chain(&task.outbox));
    runs.find(|run| run.number == FOLLOWED)
}

/// The activity that is followed.
pub(super) fn followed(state: &State) -> Option<Followed<'_>> {
    let pending = state.pending.iter().find(|pending| pending.number == FOLLOWED);
    let pending = pending.map(|pending| Followed::Pending(pending.service));
    pending.or_else(|| run_of(state).map(Followed::Runs))
}

pub(super) enum Followed<'a> {
    Pending(u16),
    Runs(&'a Run),
}

/// The service that a request is of which was not answered.
pub(super) fn due(system: &System, state: &State) -> Option<u16> {
    match followed(state) {
        Some(Followed::Pending(service)) => Some(service),
        Some(Followed::Runs(run)) => system.service_of(run),
        None => state.workers.first().map(|worker| worker.service),
    }
}

/// Whether no answer is due in a state: there is no request, or an activity runs that goes on until
/// somebody asks it to stop, or sleeps until then or until an event.
pub(super) fn is_fine(system: &System, state: &State) -> bool {
    match followed(state) {
        Some(Followed::Pending(_)) => false,
        Some(Followed::Runs(run)) => {
            let machine = &system.machines[usize::from(run.machine)];
            let asleep = || {
                !run.places.is_empty() && run.places.iter().all(|place| place.mode == Mode::Asleep)
            };
            let goes_on = run.life == Life::Run && !run.asked && run.end.is_none();
            goes_on && (is_endless(system, machine) || asleep())
        }
        None => state.workers.is_empty(),
    }
}

/// What a request waits for that does not come.
pub(super) fn why(system: &System, state: &State, service: u16) -> String {
    match followed(state) {
        Some(Followed::Pending(_)) => {
            let interrupts = &system.services[usize::from(service)].interrupts;
            let tasks = state.tasks.iter();
            let runs = tasks.flat_map(crate::rules::runs_of);
            let others = runs.filter(|run| run.number != FOLLOWED && run.life != Life::Init);
            let others = others.filter_map(|run| system.service_of(run));
            let others = others.filter(|other| interrupts[usize::from(*other)]);
            let names: Vec<String> = others.map(|other| system.service_name(other)).collect();
            format!("it waits for the end of {}, which may not come", names.join(", "))
        }
        Some(Followed::Runs(run)) => {
            let machine = &system.machines[usize::from(run.machine)];
            let states: Vec<&str> =
                run.places.iter().map(|place| system.state_name(place.state)).collect();
            let paused = run.places.iter().any(|place| place.mode == Mode::Paused);
            if paused && system.is_aperiodic(machine.task) {
                format!(
                    "it pauses in {}, and its task has no period: that takes something else to happen",
                    states.join(", ")
                )
            } else if states.is_empty() {
                "nothing that happens by itself ends it".into()
            } else {
                format!(
                    "nothing that happens by itself leads from {} to its end",
                    states.join(", ")
                )
            }
        }
        None => "nothing that happens by itself ends it".into(),
    }
}

/// Whether an activity of this machine runs until it is asked to stop: no way from its start leads to
/// an end.
pub(super) fn is_endless(system: &System, machine: &Machine) -> bool {
    machine.codel(machine.start).is_some() && !ends_from(system, machine, machine.start, false)
}
