//! Which activities of a task there can be at the same time (R12).

use crate::codels::small;
use crate::system::System;

/// Activities that are looked at in all combinations; of more, all count.
const MOST: usize = 20;

/// The dearest activities of a task that there can be in one cycle: pairs of a service and its
/// cost. Of two that interrupt each other, only one has begun at a time.
pub(super) fn dearest(system: &System, costs: &[(u16, u64)]) -> Vec<(u16, u64)> {
    let mut all: Vec<(u16, u64)> = Vec::new();
    for &(service, cost) in costs {
        let alone = together(system, service, service);
        let count = if alone { system.bounds.instances } else { 1 };
        all.extend(std::iter::repeat_n((service, cost), count.min(system.bounds.slots)));
    }
    all.sort_by_key(|(_, cost)| std::cmp::Reverse(*cost));
    if all.len() > MOST {
        all.truncate(system.bounds.slots);
        return all;
    }
    let mut best = (0, Vec::new());
    choose(system, &all, &mut Vec::new(), 0, &mut best);
    best.1
}

/// Whether activities of two services may both have begun: the one that begins last does not
/// interrupt the other.
fn together(system: &System, a: u16, b: u16) -> bool {
    let interrupts = |a: u16, b: u16| system.services[usize::from(a)].interrupts[usize::from(b)];
    !(interrupts(a, b) && interrupts(b, a))
}

fn choose(
    system: &System,
    left: &[(u16, u64)],
    chosen: &mut Vec<(u16, u64)>,
    cost: u64,
    best: &mut (u64, Vec<(u16, u64)>),
) {
    if cost > best.0 {
        *best = (cost, chosen.clone());
    }
    let rest: u64 = left.iter().map(|(_, cost)| *cost).fold(0, u64::saturating_add);
    let full = chosen.len() >= system.bounds.slots;
    let Some(((service, own), after)) = left.split_first() else { return };
    if full || cost.saturating_add(rest) <= best.0 {
        return;
    }
    if chosen.iter().all(|(other, _)| together(system, *service, *other)) {
        chosen.push((*service, *own));
        choose(system, after, chosen, cost.saturating_add(*own), best);
        chosen.pop();
    }
    choose(system, after, chosen, cost, best);
}

/// The services whose activities a task runs.
pub(super) fn services_of(system: &System, task: u16) -> Vec<(u16, u16)> {
    let machines = system.machines.iter().zip(0..small(system.machines.len()));
    let of_task = machines.filter(|(machine, _)| machine.task == task);
    of_task.filter_map(|(machine, at)| Some((machine.service?, at))).collect()
}
