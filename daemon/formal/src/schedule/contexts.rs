//! Who executes which nodes, and how long one waits for others (R5).

use crate::codels::small;
use crate::services::Work;
use crate::system::System;
use crate::timed::Times;

/// For each context, the nodes that it executes.
pub(super) struct Contexts {
    nodes: Vec<Vec<u16>>,
}

/// What a context may execute while another one waits for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    pub(super) context: u16,
    pub(super) node: u16,
    pub(super) time: u64,
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
            nodes[at].extend(service.work.iter().filter_map(|work| match work {
                Work::Codel(node) | Work::Transfer(node) => Some(*node),
                Work::Abort => None,
            }));
        }
        for own in &mut nodes {
            own.sort_unstable();
            own.dedup();
        }
        Self { nodes }
    }

    /// What may be ahead of a context that arrives at a node: who arrives later is behind, so each
    /// other context is there once at most, with a node that conflicts, or that one of those waits
    /// for. Only contexts that `counts` accepts are listed.
    pub(super) fn ahead(
        &self,
        system: &System,
        times: &Times,
        (own, node): (u16, u16),
        counts: impl Fn(u16) -> bool,
    ) -> Vec<Ahead> {
        let others = || {
            let all = self.nodes.iter().zip(0u16..).filter(|(_, context)| *context != own);
            all.flat_map(|(nodes, context)| nodes.iter().map(move |node| (context, *node)))
        };
        // All nodes that are linked to this one by conflicts.
        let mut linked = vec![node];
        let mut at = 0;
        while let Some(one) = linked.get(at).copied() {
            for (_, other) in others() {
                if system.conflicts.between(one, other) && !linked.contains(&other) {
                    linked.push(other);
                }
            }
            at += 1;
        }
        let mut ahead: Vec<Ahead> = Vec::new();
        for (context, other) in others() {
            if !linked.contains(&other) || !counts(context) {
                continue;
            }
            let time = times.of(other).most.unwrap_or(0);
            match ahead.last_mut().filter(|last| last.context == context) {
                Some(last) if last.time < time => (last.node, last.time) = (other, time),
                Some(_) => {}
                None => ahead.push(Ahead { context, node: other, time }),
            }
        }
        let tasks = small(system.periods.len());
        let (mut ahead, mut workers): (Vec<Ahead>, Vec<Ahead>) =
            ahead.into_iter().filter(|one| one.time > 0).partition(|one| one.context < tasks);
        // Only so many requests are served at the same time.
        workers.sort_by_key(|one| std::cmp::Reverse(one.time));
        workers.truncate(system.bounds.requests);
        ahead.extend(workers);
        ahead
    }
}
