//! What can be said of a component that is too large to see all its states: from its rules, and from
//! what it can do if clients request one service at a time.

use genom_description::model::{Codel, Owner};

use super::graph::reached;
use super::order::needed;
use super::verdict::{Property, Verdict};
use crate::action::Answer;
use crate::codels::small;
use crate::explore::{Explored, Limits};
use crate::services::Work;
use crate::state::{Pc, Phase};
use crate::system::System;

/// States of one part, at most.
const PART: usize = 100_000;

/// What the parts of a component show.
pub(super) struct Parts {
    /// Requests are served in some run.
    runs: bool,
    /// All codels and services can run.
    all_reached: bool,
    /// There is always a next step.
    goes_on: bool,
    /// Conflicts are symmetric: who is kept out keeps out.
    symmetric: bool,
}

impl Parts {
    pub(super) fn new(system: &System, limits: &Limits) -> Self {
        let (runs, all_reached) = shown(system, limits);
        let nodes = 0..small(system.plan.nodes().len());
        let even = |a: u16| {
            let mut others = nodes.clone();
            others.all(|b| system.conflicts.between(a, b) == system.conflicts.between(b, a))
        };
        Self { runs, all_reached, goes_on: goes_on(system), symmetric: nodes.clone().all(even) }
    }

    /// `Holds`, if that can be said.
    pub(super) fn verdict(&self, property: Property) -> Option<Verdict> {
        let holds = match property {
            Property::Start => self.runs,
            Property::Reach => self.all_reached,
            Property::Stuck => self.goes_on,
            Property::Exclude => self.symmetric,
            Property::Loop | Property::Stop | Property::Order => false,
        };
        holds.then_some(Verdict::Holds)
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

/// Whether requests are served, and all codels and services can run, by runs in which clients
/// request few services.
fn shown(system: &System, limits: &Limits) -> (bool, bool) {
    let model = system.plan.component();
    let own = |codel: &Codel| match codel.owner {
        Owner::Service(service) => !model.services[service].standard,
        Owner::Task(_) => true,
    };
    let mut unseen: Vec<bool> = model.codels.iter().map(own).collect();
    let mut unserved: Vec<bool> =
        system.services.iter().map(|service| service.builtin.is_none()).collect();
    let mut runs = false;
    let requested = |service: &u16| system.services[usize::from(*service)].builtin.is_none();
    let services = (0..small(system.services.len())).filter(requested);
    let services = services.map(|service| needed(system, service));
    let parts: Vec<Vec<u16>> = std::iter::once(Vec::new()).chain(services).collect();
    // First with few clients, who let the component run; then as the bounds say.
    for (part, small) in
        parts.iter().map(|part| (part, true)).chain(parts.iter().map(|part| (part, false)))
    {
        let last = part.first().copied();
        let wanted = codels_of(system, last);
        let seen = last.is_none_or(|service| !unserved[usize::from(service)])
            && wanted.iter().all(|codel| !unseen[usize::from(*codel)]);
        if runs && seen {
            continue;
        }
        let mut slice = system.slice(part);
        if small && last.is_some() {
            (slice.bounds.instances, slice.bounds.requests, slice.bounds.kill) = (1, 1, false);
        }
        let limits = Limits { states: limits.states.min(PART), ..*limits };
        Explored::whilst(&slice, &limits, |_, state, _| {
            runs |= state.phase == Phase::Running;
            for (_, node) in state.lock.holders() {
                if let Some(unseen) = unseen.get_mut(usize::from(node)) {
                    *unseen = false;
                }
            }
            for worker in &state.workers {
                if worker.pc == Pc::Conclude {
                    unserved[usize::from(worker.service)] = false;
                }
            }
            let served = last.is_none_or(|service| !unserved[usize::from(service)]);
            !(runs && served && wanted.iter().all(|codel| !unseen[usize::from(*codel)]))
        });
    }
    (runs, !unseen.contains(&true) && !unserved.contains(&true))
}

/// Codels of a service, or of all permanent activities.
fn codels_of(system: &System, service: Option<u16>) -> Vec<u16> {
    let machines = system.machines.iter().filter(|machine| machine.service == service);
    let mut codels: Vec<u16> = machines.flat_map(|m| m.codels.iter().flatten().copied()).collect();
    if let Some(service) = service {
        let work = &system.services[usize::from(service)].work;
        codels.extend(work.iter().filter_map(|work| match work {
            Work::Codel(codel) => Some(*codel),
            Work::Transfer(_) | Work::Abort => None,
        }));
    }
    codels
}
