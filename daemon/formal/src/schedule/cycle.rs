//! The dearest cycle of a task: codels with what they wait for.

use super::contexts::{Adds, Ahead, Contexts};
use super::ways::{Endless, Way, Ways};
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;
use genom_timing::dearest;

/// The dearest cycle of a task.
pub(super) struct Cycle {
    pub(super) cost: u64,
    /// What the cycle costs in which its permanent activity begins, of that activity.
    pub(super) permanent: u64,
    /// Activities, by machine, with the codels that they execute.
    pub(super) ways: Vec<(u16, Vec<u16>)>,
    /// For each node, what may be ahead of it.
    pub(super) ahead: Vec<Vec<Ahead>>,
}

/// Which cycles of a task are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cycles {
    All,
    /// Those that ticks begin while requests are served.
    Ticks,
}

/// What each node costs where a task executes it, and what may be ahead of it.
pub(super) struct Costs {
    pub(super) costs: Vec<u64>,
    pub(super) ahead: Vec<Vec<Ahead>>,
}

impl Costs {
    /// With what a task waits for. `counts` says which contexts count there.
    pub(super) fn new(
        system: &System,
        times: &Times,
        contexts: &Contexts,
        task: u16,
        (counts, adds): (&dyn Fn(u16) -> bool, Adds),
    ) -> Self {
        let mut ahead = vec![Vec::new(); system.plan.nodes().len()];
        for &node in contexts.of(task) {
            ahead[usize::from(node)] = contexts.ahead(system, times, (task, node), counts, adds);
        }
        let waits =
            |node: usize| ahead[node].iter().map(|one| one.time).fold(0, u64::saturating_add);
        let cost = |node: usize| {
            let most = times.of(crate::codels::small(node)).most.unwrap_or(0);
            most.saturating_add(waits(node))
        };
        Self { costs: (0..ahead.len()).map(cost).collect(), ahead }
    }
}

impl Cycle {
    /// The dearest cycle of a task, if nodes cost this: of all; or of those that ticks begin while
    /// requests are served, so that permanent activities neither begin nor stop.
    pub(super) fn new(
        system: &System,
        task: u16,
        costs: Costs,
        of: Cycles,
    ) -> Result<Self, Endless> {
        let Costs { costs, ahead } = costs;
        let way = |machine: u16, of: Cycles| -> Result<Way, Endless> {
            let machine = &system.machines[usize::from(machine)];
            let ways = Ways { system, machine, costs: &costs };
            let mut way = if of == Cycles::All { ways.cycle()? } else { ways.resumed()? };
            if let Some(fetch) = machine.fetch {
                way.cost = way.cost.saturating_add(costs[usize::from(fetch)]);
                way.codels.push(fetch);
            }
            Ok(way)
        };
        let machine = system.permanent(task);
        let permanent = way(machine, Cycles::All)?.cost;
        let first = way(machine, of)?;
        let (mut total, mut ways) = (first.cost, vec![(machine, first.codels)]);
        let mut all = Vec::new();
        let requested = services_of(system, task).into_iter();
        for (service, machine) in requested.filter(|(one, _)| system.clients[usize::from(*one)]) {
            all.push((service, machine, way(machine, Cycles::All)?));
        }
        let weights: Vec<(u16, u64)> =
            all.iter().map(|(service, _, way)| (*service, way.cost)).collect();
        // Of two that interrupt each other, only one has begun at a time (R12).
        let together = |a: u16, b: u16| !(system.interrupts(a, b) && system.interrupts(b, a));
        let most = (system.bounds.slots, system.bounds.instances);
        for (service, _) in dearest(&weights, most, &together) {
            if let Some((_, machine, way)) = all.iter().find(|(other, ..)| *other == service) {
                total = total.saturating_add(way.cost);
                ways.push((*machine, way.codels.clone()));
            }
        }
        ways.retain(|(_, codels)| !codels.is_empty());
        Ok(Self { cost: total, permanent, ways, ahead })
    }
}

/// The services whose activities a task runs.
fn services_of(system: &System, task: u16) -> Vec<(u16, u16)> {
    let machines = system.machines.iter().zip(0..small(system.machines.len()));
    let of_task = machines.filter(|(machine, _)| machine.task == task);
    of_task.filter_map(|(machine, at)| Some((machine.service?, at))).collect()
}
