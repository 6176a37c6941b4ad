//! Who executes which nodes, and how long one waits for others (R5).

use crate::codels::small;
use crate::services::Work;
use crate::system::System;
use crate::timed::Times;
pub(super) use genom_timing::Ahead;
use genom_timing::Chains;

/// For each context, the nodes that it executes; for each node, who executes what it excludes.
pub(super) struct Contexts {
    nodes: Vec<Vec<u16>>,
    /// Contexts and their nodes that conflict with a node.
    rivals: Vec<Vec<(u16, u16)>>,
    tasks: u16,
}

/// How what is ahead adds up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Adds {
    /// Each context has a processor: what does not wait for each other is executed side by side.
    Chain,
    /// They share processors: one after another.
    All,
}

impl Contexts {
    pub(super) fn new(system: &System) -> Self {
        Self::with(system, &|_, _| true)
    }

    /// The same with the nodes of a context that `may` accepts, and no others.
    pub(super) fn with(system: &System, may: &dyn Fn(u16, u16) -> bool) -> Self {
        let mut nodes = vec![Vec::new(); system.periods.len() + system.services.len()];
        for machine in &system.machines {
            let own = &mut nodes[usize::from(machine.task)];
            own.extend(machine.codels.iter().flatten());
            own.extend(machine.fetch);
        }
        for (service, at) in system.services.iter().zip(system.periods.len()..) {
            if !system.clients[at - system.periods.len()] {
                continue;
            }
            nodes[at].extend(service.work.iter().filter_map(|work| match work {
                Work::Codel(node) | Work::Transfer(node) => Some(*node),
                Work::Abort => None,
            }));
        }
        for (own, context) in nodes.iter_mut().zip(0u16..) {
            own.retain(|node| may(context, *node));
            own.sort_unstable();
            own.dedup();
        }
        let mut rivals = vec![Vec::new(); system.plan.nodes().len()];
        for (own, context) in nodes.iter().zip(0u16..) {
            for (node, rivals) in (0u16..).zip(&mut rivals) {
                let conflicting = own.iter().filter(|o| system.conflicts.between(node, **o));
                rivals.extend(conflicting.map(|other| (context, *other)));
            }
        }
        Self { nodes, rivals, tasks: small(system.periods.len()) }
    }

    /// The nodes of a context.
    pub(super) fn of(&self, context: u16) -> &[u16] {
        &self.nodes[usize::from(context)]
    }

    /// Contexts and their nodes that conflict with a node.
    pub(super) fn rivals(&self, node: u16) -> &[(u16, u16)] {
        &self.rivals[usize::from(node)]
    }

    /// What may be ahead of a context that arrives at a node: who arrives later is behind, so each
    /// other context is there once at most, with a node that conflicts, or that one of those waits
    /// for. Only contexts that `counts` accepts are listed.
    pub(super) fn ahead(
        &self,
        system: &System,
        times: &Times,
        (own, node): (u16, u16),
        counts: &dyn Fn(u16) -> bool,
        adds: Adds,
    ) -> Vec<Ahead> {
        let all = self.all(system, times, (own, node), counts);
        if adds == Adds::All {
            return all;
        }
        let sum = |ahead: &[Ahead]| ahead.iter().map(|one| one.time).fold(0, u64::saturating_add);
        let most = |node: u16| times.of(node).most.unwrap_or(0);
        let time = |context: u16, node: u16| if counts(context) { most(node) } else { 0 };
        let workers = system.bounds.requests.min(system.services.len());
        match Chains::new(&self.rivals, self.tasks, &time).longest((own, node), workers) {
            Some(chain) if sum(&chain) <= sum(&all) => chain,
            _ => all,
        }
    }

    /// All that may be ahead, whether it waits for each other or not.
    pub(super) fn all(
        &self,
        system: &System,
        times: &Times,
        (own, node): (u16, u16),
        counts: &dyn Fn(u16) -> bool,
    ) -> Vec<Ahead> {
        let linked = self.linked(own, &[node]);
        let mut ahead: Vec<Ahead> = Vec::new();
        for (nodes, context) in self.nodes.iter().zip(0u16..) {
            if context == own || !counts(context) {
                continue;
            }
            let nodes = nodes.iter().filter(|other| linked.contains(other));
            let time = |node: &u16| times.of(*node).most.unwrap_or(0);
            if let Some(node) = nodes.max_by_key(|node| time(node)) {
                ahead.push(Ahead { context, node: *node, time: time(node) });
            }
        }
        let (mut ahead, mut workers): (Vec<Ahead>, Vec<Ahead>) =
            ahead.into_iter().filter(|one| one.time > 0).partition(|one| one.context < self.tasks);
        // Only so many requests are served at the same time.
        workers.sort_by_key(|one| std::cmp::Reverse(one.time));
        workers.truncate(system.bounds.requests);
        ahead.extend(workers);
        ahead
    }

    /// All nodes of other contexts that may be ahead of these, directly or not.
    pub(super) fn linked(&self, own: u16, nodes: &[u16]) -> Vec<u16> {
        let mut linked: Vec<u16> = Vec::new();
        let mut left = nodes.to_vec();
        while let Some(node) = left.pop() {
            for (context, other) in self.rivals(node) {
                if *context != own && !linked.contains(other) {
                    linked.push(*other);
                    left.push(*other);
                }
            }
        }
        linked
    }
}
