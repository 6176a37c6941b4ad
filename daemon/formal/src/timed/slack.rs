//! By how much codels are too long for a task.

use super::explore::Timed;
use super::spent::last_cycle;
use super::times::Times;
use crate::action::Action;
use crate::state::State;
use crate::system::System;
use genom_timing::Limits;
use genom_timing::below;

/// Zones of an exploration that is repeated with other times.
const MOST: usize = 5_000;
/// The part of the time of a search that all of them together get.
const PART: u32 = 20;

/// The codels in the last cycle of a task in a run, and those of other contexts meanwhile.
pub(super) fn involved(run: &[(State, Action)], task: u16) -> Vec<u16> {
    let mut nodes = Vec::new();
    for (state, _) in &run[last_cycle(run, task)..] {
        for (_, node) in state.lock.holders() {
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
    }
    nodes
}

impl System {
    /// For each of these codels, the time below which it would have to stay, all others as they are,
    /// so that the task ends each cycle before its next tick. Codels for which that is not enough are
    /// left out; all are, if the component is too large to be explored many times.
    pub(super) fn needed(
        &self,
        times: &Times,
        limits: &Limits,
        task: usize,
        (codels, zones): (&[u16], usize),
    ) -> Vec<(u16, u64)> {
        if zones > MOST {
            return Vec::new();
        }
        let begin = std::time::Instant::now();
        let time = limits.time / PART;
        let holds = |codel: u16, most: u64| {
            let times = times.with_most(codel, most);
            let timed = Timed::until(self, &times, limits, Some(task));
            timed.limit.is_none() && timed.overruns[task].is_none()
        };
        let bound = |codel: &u16| {
            let duration = times.of(*codel);
            Some((*codel, below(duration.least, duration.most?, |most| holds(*codel, most))?))
        };
        let in_time = |_: &&u16| begin.elapsed() < time;
        codels.iter().take_while(in_time).filter_map(bound).collect()
    }
}
