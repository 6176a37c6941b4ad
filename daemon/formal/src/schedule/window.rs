//! What a task waits for in a whole cycle: no more than others execute in that time.
//!
//! For one codel after another, each other task would be ahead with its longest one each time. But a
//! task with a period has only so many cycles while another one lasts.

use super::contexts::{Adds, Contexts};
use super::cycle::{Costs, Cycle, Cycles};
use super::known::{Known, Meanwhile};
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;
use genom_timing::{Period, cycles};

/// Tasks that are counted for whole cycles, in all combinations.
const MOST: usize = 5;

pub(super) struct Window<'a> {
    system: &'a System,
    times: &'a Times,
    contexts: &'a Contexts,
}

/// What another task executes in each of its cycles that is waited for.
#[derive(Clone, Copy)]
struct Other {
    task: u16,
    each: u64,
    period: Period,
    response: u64,
}

impl<'a> Window<'a> {
    pub(super) fn new(system: &'a System, times: &'a Times, contexts: &'a Contexts) -> Self {
        Self { system, times, contexts }
    }

    /// Lowers the bounds of tasks, for as long as a lower one lowers another.
    pub(super) fn narrow(&self, known: &mut [Known]) {
        for _ in 0..=known.len() {
            let mut lower = false;
            for task in 0..small(known.len()) {
                lower |= self.narrow_one(known, task);
            }
            if !lower {
                break;
            }
        }
    }

    fn narrow_one(&self, known: &mut [Known], task: u16) -> bool {
        let (Some(period), Some(cycle)) =
            (self.system.periods[usize::from(task)], &known[usize::from(task)].cycle)
        else {
            return false;
        };
        let linked = self.contexts.linked(task, self.contexts.of(task));
        let others: Vec<Other> =
            known.iter().filter_map(|other| self.other(other, task, &linked)).take(MOST).collect();
        let late = known[usize::from(task)].load.late;
        // A node that takes no time may be arrived at when the cycle would end, and others tick.
        let most = |node: &u16| self.times.of(*node).most.unwrap_or(0);
        let reach = u64::from(self.contexts.of(task).iter().any(|node| most(node) == 0));
        let mut best: Option<(Cycle, Vec<Meanwhile>)> = None;
        let mut least = cycle.cost;
        for chosen in 1u32..1 << others.len() {
            let counted = |at: usize| chosen & (1 << at) != 0;
            let chosen: Vec<Other> =
                (0..others.len()).filter(|at| counted(*at)).map(|at| others[at]).collect();
            let rest = |context: u16| chosen.iter().all(|other| other.task != context);
            let counts = (&rest as &dyn Fn(u16) -> bool, Adds::Chain);
            let costs = Costs::new(self.system, self.times, self.contexts, task, counts);
            let Ok(cycle) = Cycle::new(self.system, task, costs, Cycles::Ticks) else { continue };
            if let Some((cost, meanwhile)) =
                self.settled(cycle.cost, (late, reach), period, &chosen)
                && cost < least
            {
                least = cost;
                best = Some((Cycle { cost, ..cycle }, meanwhile));
            }
        }
        let Some((cycle, meanwhile)) = best else { return false };
        let known = &mut known[usize::from(task)];
        known.load.work = cycle.cost;
        (known.cycle, known.meanwhile) = (Some(cycle), meanwhile);
        true
    }

    /// What another task executes that is waited for, if its cycles are in time.
    fn other(&self, other: &Known, task: u16, linked: &[u16]) -> Option<Other> {
        let period = self.system.periods[usize::from(other.task)]?;
        let response = other.load.work.saturating_add(other.load.late);
        if other.task == task || other.cycle.is_none() || response >= period.period {
            return None;
        }
        let cost = |node: u16| {
            let counts = linked.contains(&node);
            if counts { self.times.of(node).most.unwrap_or(0) } else { 0 }
        };
        let nodes = 0..small(self.system.plan.nodes().len());
        let costs = Costs { costs: nodes.map(cost).collect(), ahead: Vec::new() };
        let each = Cycle::new(self.system, other.task, costs, Cycles::Ticks).ok()?.cost;
        Some(Other { task: other.task, each, period, response })
    }

    /// The length of a cycle that counts what others execute meanwhile; `None` if it does not end
    /// before the next tick. Others count that tick less than `reach` after its end.
    fn settled(
        &self,
        own: u64,
        (late, reach): (u64, u64),
        period: Period,
        others: &[Other],
    ) -> Option<(u64, Vec<Meanwhile>)> {
        let mut cost = own;
        loop {
            let length = cost.saturating_add(late);
            if length >= period.period {
                return None;
            }
            let cycles: Vec<u64> = others
                .iter()
                .map(|other| cycles(period, length + reach, (other.period, other.response)))
                .collect();
            let meanwhile = others.iter().zip(&cycles);
            let meanwhile = meanwhile.map(|(other, cycles)| cycles.saturating_mul(other.each));
            let next = meanwhile.fold(own, u64::saturating_add);
            if next <= cost {
                let name = |other: &Other| self.system.task_name(other.task);
                let told = others.iter().zip(cycles).map(|(other, cycles)| Meanwhile {
                    of: name(other),
                    cycles,
                    each: other.each,
                });
                return Some((cost, told.filter(|one| one.each > 0).collect()));
            }
            cost = next;
        }
    }
}
