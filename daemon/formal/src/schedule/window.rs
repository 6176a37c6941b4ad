//! What a task waits for in a whole cycle: no more than others execute in that time.
//!
//! For one codel after another, each other task would be ahead with its longest one each time. But a
//! task with a period has only so many cycles while another one lasts.

use super::contexts::{Adds, Contexts};
use super::cycle::{Costs, Cycle, Cycles};
use super::known::{Known, Meanwhile};
use crate::codels::small;
use crate::system::{Period, System};
use crate::timed::Times;

/// Tasks that are counted for whole cycles, in all combinations.
const MOST: usize = 5;
/// Dates of ticks that are looked at.
const TICKS: u64 = 4_096;

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
            let cycles: Vec<u64> =
                others.iter().map(|other| cycles(period, length + reach, other)).collect();
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

/// Cycles of another task that there may be in part while one of this length lasts from a tick on:
/// all dates of ticks are known.
fn cycles(own: Period, length: u64, other: &Other) -> u64 {
    let (period, response) = (other.period.period, other.response);
    let common = lcm(own.period, period).map(|common| common / own.period);
    let Some(ticks) = common.filter(|ticks| *ticks <= TICKS) else {
        return (length.saturating_add(response) / period).saturating_add(1);
    };
    let count = |tick: u64| {
        // Later by a period of the other, so that nothing is below zero.
        let begin = own.delay + tick * own.period + period;
        // Ticks before the end whose cycles may end after the beginning.
        let before = |date: u64| {
            let first = other.period.delay;
            if date <= first { 0 } else { (date - first).div_ceil(period) }
        };
        let ends = begin.saturating_sub(response).saturating_add(1);
        before(begin + length).saturating_sub(before(ends))
    };
    (0..ticks).map(count).max().unwrap_or(0)
}

fn lcm(a: u64, b: u64) -> Option<u64> {
    let (mut x, mut y) = (a, b);
    while y > 0 {
        (x, y) = (y, x % y);
    }
    (a / x.max(1)).checked_mul(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_counted_at_the_dates_of_their_ticks() {
        let own = Period { period: 10, delay: 0 };
        let other = |period: u64, delay: u64, response: u64| Other {
            task: 1,
            each: 1,
            period: Period { period, delay },
            response,
        };
        // Both at zero: the one of 40 is over when the next of 10 begins, or is not.
        assert_eq!(cycles(own, 5, &other(40, 0, 10)), 1);
        assert_eq!(cycles(own, 5, &other(40, 0, 35)), 1);
        // Two ticks of 5 are in a cycle of 6, one in a cycle of 5.
        assert_eq!(cycles(own, 6, &other(5, 0, 2)), 2);
        assert_eq!(cycles(own, 5, &other(5, 0, 2)), 1);
        // With another delay, an earlier one may go on.
        assert_eq!(cycles(own, 2, &other(10, 5, 5)), 0);
        assert_eq!(cycles(own, 2, &other(10, 5, 6)), 1);
        // All pairs of dates, one by one.
        for (period, delay, response, length) in
            [(7, 3, 4, 9), (3, 1, 2, 8), (15, 14, 6, 3), (10, 9, 9, 4), (4, 0, 3, 9)]
        {
            let count = |tick: u64| {
                let (begin, end) = (tick * 10, tick * 10 + length);
                let ticks = (0..2_000).map(|n| delay + n * period);
                ticks.filter(|t| *t < end && t + response > begin).count()
            };
            let most = (0..200).map(count).max().unwrap() as u64;
            assert_eq!(cycles(own, length, &other(period, delay, response)), most);
        }
    }
}
