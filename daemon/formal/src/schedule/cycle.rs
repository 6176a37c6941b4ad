//! The dearest cycle of a task: codels with what they wait for.

use super::alive::{dearest, services_of};
use super::contexts::{Ahead, Contexts};
use super::ways::{Endless, Way, Ways};
use crate::system::System;
use crate::timed::Times;

/// The dearest cycle of a task.
pub(super) struct Cycle {
    pub(super) cost: u64,
    /// Activities, by machine, with the codels that they execute.
    pub(super) ways: Vec<(u16, Vec<u16>)>,
    /// For each node, what may be ahead of it.
    pub(super) ahead: Vec<Vec<Ahead>>,
}

impl Cycle {
    /// The dearest cycle of a task. `counts` says which contexts count where it waits.
    pub(super) fn new(
        system: &System,
        times: &Times,
        contexts: &Contexts,
        task: u16,
        counts: impl Fn(u16) -> bool,
    ) -> Result<Self, Endless> {
        let mut ahead = vec![Vec::new(); system.plan.nodes().len()];
        let own = system.machines.iter().filter(|machine| machine.task == task);
        let nodes = own.flat_map(|machine| machine.codels.iter().flatten().chain(&machine.fetch));
        for &node in nodes {
            ahead[usize::from(node)] = contexts.ahead(system, times, (task, node), &counts);
        }
        let waits =
            |node: usize| ahead[node].iter().map(|one| one.time).fold(0, u64::saturating_add);
        let cost = |node: usize| {
            let most = times.of(crate::codels::small(node)).most.unwrap_or(0);
            most.saturating_add(waits(node))
        };
        let costs: Vec<u64> = (0..ahead.len()).map(cost).collect();
        let way = |machine: u16| -> Result<Way, Endless> {
            let machine = &system.machines[usize::from(machine)];
            let mut way = Ways { system, machine, costs: &costs }.cycle()?;
            if let Some(fetch) = machine.fetch {
                way.cost = way.cost.saturating_add(costs[usize::from(fetch)]);
                way.codels.push(fetch);
            }
            Ok(way)
        };
        let permanent = system.permanent(task);
        let first = way(permanent)?;
        let (mut total, mut ways) = (first.cost, vec![(permanent, first.codels)]);
        let mut all = Vec::new();
        for (service, machine) in services_of(system, task) {
            all.push((service, machine, way(machine)?));
        }
        let weights: Vec<(u16, u64)> =
            all.iter().map(|(service, _, way)| (*service, way.cost)).collect();
        for (service, _) in dearest(system, &weights) {
            if let Some((_, machine, way)) = all.iter().find(|(other, ..)| *other == service) {
                total = total.saturating_add(way.cost);
                ways.push((*machine, way.codels.clone()));
            }
        }
        ways.retain(|(_, codels)| !codels.is_empty());
        Ok(Self { cost: total, ways, ahead })
    }
}
