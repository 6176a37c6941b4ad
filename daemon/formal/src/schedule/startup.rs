//! The first cycles of tasks, which begin when the task before has made its first pass, not at a tick
//! (R1).

use super::contexts::{Adds, Contexts};
use super::cycle::Costs;
use super::known::{Cause, Known};
use crate::system::System;
use crate::timed::Times;
use genom_timing::Period;

/// When first cycles are over.
pub(super) struct Startup {
    /// For each task, the date by which its first cycle has ended; `None` if there is no bound.
    ends: Vec<Option<u64>>,
    /// The longest first cycles.
    lasts: Vec<u64>,
}

impl Startup {
    pub(super) fn new(
        system: &System,
        times: &Times,
        contexts: &Contexts,
        known: &[Known],
    ) -> Self {
        let (mut begins, mut ends, mut lasts) = (0u64, Vec::new(), Vec::new());
        for one in known {
            let task = one.task;
            let machine = &system.machines[usize::from(system.permanent(task))];
            let start = |counts: &dyn Fn(u16) -> bool| {
                let costs = Costs::new(system, times, contexts, task, (counts, Adds::Chain)).costs;
                machine.codel(machine.start).map_or(0, |codel| costs[usize::from(codel)])
            };
            // In its first pass only those are there that started before.
            let first = start(&|context| context < task);
            let cycle = one.cycle.as_ref().map(|cycle| cycle.permanent);
            let rest = cycle.map(|cycle| cycle.saturating_sub(start(&|_| true)));
            let last = rest.map(|rest| rest.saturating_add(first));
            ends.push(last.map(|last| last.saturating_add(begins)));
            lasts.push(last.unwrap_or(0));
            begins = begins.saturating_add(first);
        }
        Self { ends, lasts }
    }

    /// Whether all first cycles are over before the first tick of any task. Else a cycle that a tick
    /// begins may wait for what others only execute in theirs.
    pub(super) fn is_regular(&self, system: &System) -> bool {
        let first = system.periods.iter().flatten().map(|period| period.first()).min();
        let periodic = system.periods.iter().zip(&self.ends).filter(|(period, _)| period.is_some());
        let mut ends = periodic.map(|(_, ends)| *ends);
        ends.all(|ends| ends.is_some_and(|ends| Some(ends) < first))
    }

    fn is_before(&self, task: usize, period: Period) -> bool {
        self.ends[task].is_some_and(|ends| ends < period.first())
    }

    /// The longest time from a tick to the end of its cycle, if it may have been kept until the
    /// first cycle was over.
    pub(super) fn longer(
        &self,
        system: &System,
        task: &Known,
        response: Result<u64, Cause>,
    ) -> Result<u64, Cause> {
        let index = usize::from(task.task);
        match (response, system.periods[index]) {
            (Ok(response), Some(period)) if !self.is_before(index, period) => {
                let all = response.saturating_add(self.lasts[index]);
                if all < period.period { Ok(all) } else { Err(Cause::Late(all)) }
            }
            (response, _) => response,
        }
    }
}
