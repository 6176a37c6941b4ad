//! Who executes which nodes, and how long one waits for others (R5).

use crate::codels::small;
use crate::services::Work;
use crate::system::System;
use crate::timed::Times;

/// For each context, the nodes that it executes; for each node, who executes what it excludes.
pub(super) struct Contexts {
    nodes: Vec<Vec<u16>>,
    /// Contexts and their nodes that conflict with a node.
    rivals: Vec<Vec<(u16, u16)>>,
    tasks: u16,
}

/// What a context may execute while another one waits for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    pub(super) context: u16,
    pub(super) node: u16,
    pub(super) time: u64,
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
        for own in &mut nodes {
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

    /// Whether a context is a task.
    pub(super) fn is_task(&self, context: u16) -> bool {
        context < self.tasks
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
