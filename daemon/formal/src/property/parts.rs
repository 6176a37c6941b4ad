//! What can be said of a component that is too large to see all its states: from its rules, from
//! random runs, and from what it can do if clients request one service at a time.

use std::time::Instant;

use super::graph::reached;
use super::order::needed;
use super::seen::Seen;
use super::untimed::{is_stuck, stuck};
use super::verdict::{Finding, Property, Verdict, verdict};
use super::walks::walks;
use crate::action::Answer;
use crate::codels::small;
use crate::explore::Explored;
use crate::system::System;
use genom_timing::Limits;

/// What the parts of a component show.
pub(super) struct Parts {
    /// Requests are served in some run.
    runs: bool,
    /// What never runs; `None` if something was not seen that may be possible.
    never: Option<Vec<Finding>>,
    /// There is always a next step; or a part in which there is none.
    goes_on: Option<Result<(), Finding>>,
    /// Conflicts are symmetric: who is kept out keeps out.
    symmetric: bool,
}

impl Parts {
    pub(super) fn new(system: &System, limits: &Limits) -> Self {
        let seen = shown(system, limits);
        let missing = seen.missing(system);
        let impossible = Seen::all_but_impossible(system).missing(system);
        let known = missing.iter().all(|one| impossible.contains(one));
        let nodes = 0..small(system.plan.nodes().len());
        let even = |a: u16| {
            let mut others = nodes.clone();
            others.all(|b| system.conflicts.between(a, b) == system.conflicts.between(b, a))
        };
        let goes_on = if goes_on(system) { Some(Ok(())) } else { stops(system, limits).map(Err) };
        let never = known.then_some(missing);
        Self { runs: seen.runs, never, goes_on, symmetric: nodes.clone().all(even) }
    }

    /// What can be said of a property.
    pub(super) fn verdict(&self, property: Property) -> Option<Verdict> {
        let holds = |holds: bool| holds.then_some(Verdict::Holds);
        match property {
            Property::Start => holds(self.runs),
            Property::Reach => self.never.clone().map(verdict),
            Property::Stuck => {
                self.goes_on.clone().map(|one| verdict(one.err().into_iter().collect()))
            }
            Property::Exclude => holds(self.symmetric),
            Property::Loop | Property::Stop | Property::Order | Property::Answer => None,
        }
    }
}

/// Whether there is a next step until everything has ended, by the rules alone. Ticks come for as
/// long as a periodic task has started, and tasks start in order. An activity of a task without
/// period ends if nothing after its stop waits.
fn goes_on(system: &System) -> bool {
    let ticks = system.periods.first().is_some_and(Option::is_some);
    let ends = |machine: &crate::machines::Machine| {
        let mut states = reached(system, machine, machine.stop, false);
        states.push(machine.stop);
        let codels = states.iter().filter_map(|state| machine.codel(*state));
        let mut answers = codels.flat_map(|codel| &system.codels[usize::from(codel)].answers);
        !answers.any(|answer| matches!(answer, Answer::Pause(_) | Answer::Sleep(_)))
    };
    ticks || system.machines.iter().filter(|m| system.is_aperiodic(m.task)).all(ends)
}

/// The services that runs of one part request: none, or one with all that it comes after.
fn parts(system: &System) -> Vec<Vec<u16>> {
    let requested = |service: &u16| system.services[usize::from(*service)].builtin.is_none();
    let services = (0..small(system.services.len())).filter(requested);
    let services = services.map(|service| needed(system, service));
    std::iter::once(Vec::new()).chain(services).collect()
}

/// The component with these clients; each of their services once, if `small`.
fn slice(system: &System, services: &[u16], small: bool) -> System {
    let mut slice = system.slice(services);
    if small && !services.is_empty() {
        (slice.bounds.instances, slice.bounds.requests, slice.bounds.kill) = (1, 1, false);
    }
    slice
}

/// A run of a part that ends where nothing is possible. It is one of the whole component, too: what
/// clients do not ask there they need not ask.
fn stops(system: &System, limits: &Limits) -> Option<Finding> {
    let (begin, limits) = (Instant::now(), limits.first());
    parts(system).iter().find_map(|part| {
        let mut slice = system.slice(part);
        (slice.bounds.instances, slice.bounds.requests) = (1, 1);
        let mut found = None;
        let limits = limits.share(begin, 0);
        let explored = Explored::whilst(&slice, &limits, |number, state, enabled| {
            found = is_stuck(state, enabled).then_some(number);
            found.is_none()
        });
        found.map(|number| stuck(&explored, &slice, number))
    })
}

/// What is seen in random runs, then in those in which clients request few services.
fn shown(system: &System, limits: &Limits) -> Seen {
    let mut seen = Seen::new(system);
    walks(system, |state| {
        seen.note(state);
        !seen.all(system)
    });
    let (begin, limits, parts) = (Instant::now(), limits.first(), parts(system));
    // First with few clients, who let the component run; then as the bounds say.
    for (part, small) in
        parts.iter().map(|part| (part, true)).chain(parts.iter().map(|part| (part, false)))
    {
        let service = part.first().copied();
        let done = |seen: &Seen| seen.runs && seen.all_of(system, service);
        if done(&seen) {
            continue;
        }
        let slice = slice(system, part, small);
        Explored::whilst(&slice, &limits.share(begin, 0), |_, state, _| {
            seen.note(state);
            !done(&seen)
        });
    }
    seen
}
