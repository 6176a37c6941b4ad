//! Which codels and services are seen to run.

use genom_description::model::{Codel, CodelIx, Ix as _, Owner};

use super::graph::reached;
use super::order::is_possible;
use super::verdict::Finding;
use crate::services::Work;
use crate::state::{Pc, Phase, State};
use crate::system::System;

/// What was seen in some state.
pub(super) struct Seen {
    /// Requests are served.
    pub(super) runs: bool,
    /// Nodes that are executed.
    pub(super) executed: Vec<bool>,
    /// Services of which some request is successful.
    pub(super) served: Vec<bool>,
}

impl Seen {
    pub(super) fn new(system: &System) -> Self {
        let (nodes, services) = (system.plan.nodes().len(), system.services.len());
        Self { runs: false, executed: vec![false; nodes], served: vec![false; services] }
    }

    /// Notes what is seen in a state.
    pub(super) fn note(&mut self, state: &State) {
        self.runs |= state.phase == Phase::Running;
        for (_, node) in state.lock.holders() {
            self.executed[usize::from(node)] = true;
        }
        for worker in &state.workers {
            self.served[usize::from(worker.service)] |= worker.pc == Pc::Conclude;
        }
    }

    /// Notes that all was seen but this: what cannot run by the machines and orders themselves.
    pub(super) fn all_but_impossible(system: &System) -> Self {
        let services = 0..crate::codels::small(system.services.len());
        let served: Vec<bool> = services.map(|service| is_possible(system, service)).collect();
        let mut seen = Self { runs: true, served, ..Self::new(system) };
        for machine in &system.machines {
            if machine.service.is_some_and(|service| !seen.served[usize::from(service)]) {
                continue;
            }
            let sinks = system.sinks.iter().filter(|_| system.bounds.fire);
            let begins = [machine.start, machine.stop].into_iter().chain(sinks.copied());
            for begin in begins {
                let states = reached(system, machine, begin, false);
                let states = states.into_iter().chain([begin]);
                for codel in states.filter_map(|state| machine.codel(state)) {
                    seen.executed[usize::from(codel)] = true;
                }
            }
        }
        for (service, served) in system.services.iter().zip(&seen.served) {
            for work in service.work.iter().filter(|_| *served) {
                if let Work::Codel(node) | Work::Transfer(node) = *work {
                    seen.executed[usize::from(node)] = true;
                }
            }
        }
        seen
    }

    /// What was not seen of all that ought to run.
    pub(super) fn missing(&self, system: &System) -> Vec<Finding> {
        let mut found = Vec::new();
        let model = system.plan.component();
        for (ix, codel) in model.codels.pairs() {
            if !self.executed[ix.index()] && is_own(system, codel) {
                let what = format!("codel {} never runs", codel.name);
                found.push(Finding { what, span: Some(codel.span), run: Vec::new() });
            }
        }
        for ((ix, service), facts) in model.services.pairs().zip(&system.services) {
            if facts.builtin.is_none() && !self.served[ix.index()] {
                let what = format!("no request of {} is ever accepted", service.name);
                found.push(Finding { what, span: Some(service.span), run: Vec::new() });
            }
        }
        found
    }

    /// Whether all that ought to run was seen.
    pub(super) fn all(&self, system: &System) -> bool {
        let codels = system.plan.component().codels.pairs();
        let mut services = system.services.iter().zip(&self.served);
        services.all(|(service, served)| *served || service.builtin.is_some())
            && codels
                .into_iter()
                .all(|(ix, codel)| self.executed[ix.index()] || !is_own(system, codel))
    }

    /// Whether this service, or without one the permanent activities, was seen to do all it can.
    pub(super) fn all_of(&self, system: &System, service: Option<u16>) -> bool {
        service.is_none_or(|service| self.served[usize::from(service)])
            && codels_of(system, service).iter().all(|codel| self.executed[usize::from(*codel)])
    }
}

/// Whether a codel is the component's own.
fn is_own(system: &System, codel: &Codel) -> bool {
    match codel.owner {
        Owner::Service(service) => !system.plan.component().services[service].standard,
        Owner::Task(_) => true,
    }
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
    let own = |codel: &u16| {
        let codel = system.plan.component().codels.get(CodelIx::new((*codel).into()));
        codel.is_some_and(|codel| is_own(system, codel))
    };
    codels.retain(own);
    codels
}
