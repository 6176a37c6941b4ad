//! The longest chain of nodes that wait for each other (R5), if each context has a processor.

use std::collections::HashMap;

use super::contexts::{Adds, Ahead, Contexts};
use crate::system::System;
use crate::timed::Times;

/// Tasks that a chain is looked for in all orders of.
const MOST_TASKS: u16 = 32;
/// Requests at the same time: chains do not look at who was in them already.
const MOST_WORKERS: usize = 3;
/// Beginnings of chains that are looked at.
const MOST: usize = 50_000;

/// Where a chain goes on: at a node, with the tasks that are in it already, and as many workers as
/// may still be.
type At = (u16, u32, usize);

/// Chains: what a node waits for ends last of all that are ahead of it, and waited before for one
/// that was ahead in turn. Each task is in a chain once, and as many workers as there are requests
/// at the same time.
pub(super) struct Chains<'a> {
    contexts: &'a Contexts,
    times: &'a Times,
    own: u16,
    counts: &'a dyn Fn(u16) -> bool,
    /// The longest chain from there, and its first link.
    known: HashMap<At, (u64, Option<(u16, u16)>)>,
}

impl Contexts {
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
        match Chains::new(self, times, own, counts).longest(system, node) {
            Some(chain) if sum(&chain) <= sum(&all) => chain,
            _ => all,
        }
    }
}

impl<'a> Chains<'a> {
    pub(super) fn new(
        contexts: &'a Contexts,
        times: &'a Times,
        own: u16,
        counts: &'a dyn Fn(u16) -> bool,
    ) -> Self {
        Self { contexts, times, own, counts, known: HashMap::new() }
    }

    /// The longest chain ahead of a node; `None` if there are too many to look at.
    pub(super) fn longest(mut self, system: &System, node: u16) -> Option<Vec<Ahead>> {
        if self.own >= MOST_TASKS || system.periods.len() > usize::from(MOST_TASKS) {
            return None;
        }
        let workers = system.bounds.requests.min(system.services.len());
        if workers > MOST_WORKERS {
            return None;
        }
        let mut at = (node, 1 << self.own, workers);
        self.look(at)?;
        let mut chain = Vec::new();
        while let Some((_, Some((context, node)))) = self.known.get(&at) {
            let (context, node) = (*context, *node);
            let time = self.time(context, node);
            if time > 0 {
                chain.push(Ahead { context, node, time });
            }
            at = self.next(at, context, node)?;
        }
        Some(chain)
    }

    fn look(&mut self, at: At) -> Option<u64> {
        if let Some((time, _)) = self.known.get(&at) {
            return Some(*time);
        }
        if self.known.len() > MOST {
            return None;
        }
        let mut best = (0, None);
        let contexts = self.contexts;
        for (context, node) in contexts.rivals(at.0) {
            let Some(next) = self.next(at, *context, *node) else { continue };
            let time = self.time(*context, *node).saturating_add(self.look(next)?);
            if time > best.0 {
                best = (time, Some((*context, *node)));
            }
        }
        self.known.insert(at, best);
        Some(best.0)
    }

    /// The chain with another link, if that may be.
    fn next(&self, (_, tasks, workers): At, context: u16, node: u16) -> Option<At> {
        if self.contexts.is_task(context) {
            let bit = 1u32 << context;
            (tasks & bit == 0).then_some((node, tasks | bit, workers))
        } else {
            (workers > 0).then(|| (node, tasks, workers - 1))
        }
    }

    fn time(&self, context: u16, node: u16) -> u64 {
        if (self.counts)(context) { self.times.of(node).most.unwrap_or(0) } else { 0 }
    }
}
