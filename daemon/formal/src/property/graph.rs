//! Properties of state machines by themselves.

use genom_description::model::{CodelIx, Ix as _};

use super::verdict::{Finding, Verdict, verdict};
use crate::action::Answer;
use crate::machines::Machine;
use crate::system::System;

/// Where a codel leads.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Edge {
    /// To a state, in the same cycle of its task.
    Now(u16),
    /// To a state, in a later one.
    Later(u16),
}

fn edges(system: &System, machine: &Machine, state: u16) -> Vec<Edge> {
    let Some(codel) = machine.codel(state) else { return Vec::new() };
    let edge = |answer: &Answer| match *answer {
        Answer::Go(to) if system.by_period => Some(Edge::Later(to)),
        Answer::Go(to) => Some(Edge::Now(to)),
        Answer::Pause(to) | Answer::Sleep(to) => Some(Edge::Later(to)),
        Answer::End | Answer::Fail | Answer::Ok => None,
    };
    system.codels[usize::from(codel)].answers.iter().filter_map(edge).collect()
}

/// States that can be reached from this one, by edges of a kind.
pub(super) fn reached(system: &System, machine: &Machine, from: u16, now_only: bool) -> Vec<u16> {
    let mut states: Vec<u16> = Vec::new();
    let mut left = vec![from];
    while let Some(state) = left.pop() {
        for edge in edges(system, machine, state) {
            let to = match edge {
                Edge::Now(to) => to,
                Edge::Later(to) if !now_only => to,
                Edge::Later(_) => continue,
            };
            if !states.contains(&to) {
                states.push(to);
                left.push(to);
            }
        }
    }
    states
}

/// Whether a way from a state leads to the end of the activity; if `awake`, without sleep.
pub(super) fn ends_from(system: &System, machine: &Machine, from: u16, awake: bool) -> bool {
    let (mut seen, mut left) = (vec![from], vec![from]);
    while let Some(state) = left.pop() {
        let Some(codel) = machine.codel(state) else { continue };
        for answer in &system.codels[usize::from(codel)].answers {
            let to = match *answer {
                Answer::End => return true,
                Answer::Go(to) | Answer::Pause(to) => to,
                Answer::Sleep(to) if !awake => to,
                Answer::Sleep(_) | Answer::Ok | Answer::Fail => continue,
            };
            if !seen.contains(&to) {
                seen.push(to);
                left.push(to);
            }
        }
    }
    false
}

/// Why there is no bound on the time that an activity takes once it was asked to stop, if by its
/// machine there is none.
pub(crate) fn stops_late(system: &System, service: u16) -> Option<String> {
    let machine = system.services[usize::from(service)].machine?;
    let machine = &system.machines[usize::from(machine)];
    machine.codel(machine.stop)?;
    let mut states = reached(system, machine, machine.stop, false);
    states.push(machine.stop);
    let later = |state: u16, answer: &Answer| {
        match *answer {
            Answer::Sleep(to) => Some((to, true)),
            Answer::Pause(to) => Some((to, system.is_aperiodic(machine.task))),
            Answer::Go(to) => Some((to, false)),
            Answer::End | Answer::Ok | Answer::Fail => None,
        }
        .filter(|(to, open)| {
            *open || *to == state || reached(system, machine, *to, false).contains(&state)
        })
    };
    states.into_iter().find_map(|state| {
        let codel = machine.codel(state)?;
        let answers = &system.codels[usize::from(codel)].answers;
        answers.iter().find_map(|answer| later(state, answer))?;
        let name = system.state_name(state);
        Some(format!(
            "once it was asked to stop, it may come back to {name} or wait there for ever"
        ))
    })
}

/// Cycles of states without pause in periodic tasks: the cycle of the task may never end.
pub(super) fn loops(system: &System) -> Verdict {
    let mut found = Vec::new();
    for machine in &system.machines {
        if system.periods[usize::from(machine.task)].is_none() {
            continue;
        }
        let states = (0..crate::codels::small(machine.codels.len()))
            .filter(|state| machine.codel(*state).is_some());
        let cyclic: Vec<u16> =
            states.filter(|state| reached(system, machine, *state, true).contains(state)).collect();
        if let Some(first) = cyclic.first() {
            let names: Vec<&str> = cyclic.iter().map(|state| system.state_name(*state)).collect();
            let what = format!(
                "{} may go from state to state without pause for ever: {}",
                owner(system, machine),
                names.join(", ")
            );
            found.push(Finding { what, span: span(system, machine, *first), run: Vec::new() });
        }
    }
    verdict(found)
}

/// States after `stop` that may sleep. That an end can be reached from each is a rule of descriptions
/// (E0710).
pub(super) fn stops(system: &System) -> Verdict {
    let mut found = Vec::new();
    for machine in system.machines.iter().filter(|m| m.codel(m.stop).is_some()) {
        let mut states = reached(system, machine, machine.stop, false);
        states.push(machine.stop);
        let sleeps = |state: &&u16| {
            let codel = machine.codel(**state).map(|codel| &system.codels[usize::from(codel)]);
            codel.is_some_and(|codel| codel.answers.iter().any(|a| matches!(a, Answer::Sleep(_))))
        };
        if let Some(state) = states.iter().find(sleeps) {
            let (owner, name) = (owner(system, machine), system.state_name(*state));
            let what = format!(
                "{owner} may sleep in state {name} once it was asked to stop: only an event ends that"
            );
            found.push(Finding { what, span: span(system, machine, *state), run: Vec::new() });
        }
    }
    verdict(found)
}

fn owner(system: &System, machine: &Machine) -> String {
    match machine.service {
        Some(service) => format!("activity {}", system.service_name(service)),
        None => format!("the permanent activity of {}", system.task_name(machine.task)),
    }
}

fn span(system: &System, machine: &Machine, state: u16) -> Option<genom_description::model::Span> {
    let codel = machine.codel(state)?;
    system.plan.component().codels.get(CodelIx::new(codel.into())).map(|codel| codel.span)
}
