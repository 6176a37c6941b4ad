//! Ticks that a task misses within a window that slides.

use std::collections::VecDeque;

use genom_timing::duration;
use genom_timing::memory::{ENTRY, PIECE};
use indexmap::IndexSet;

use super::clocked::{Led, Step, Watch};
use super::cycles::ends;
use crate::action::Action;
use crate::state::{At, Phase, State, Task};
use crate::system::System;

/// Missed ticks that may still count, with those of one cycle together. Each: ticks of the task since
/// the last one that this cycle missed, and how many it missed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Recent {
    /// Those of the cycle that lasts.
    now: u32,
    /// Those of cycles before, the oldest first.
    before: VecDeque<(u32, u32)>,
}

/// A rule on missed ticks.
///
/// The runtime dates missed ticks when it sees them: at the latest when the cycle ends that missed
/// them, perhaps as they come. So how far two of them are apart is known up to one period.
pub(super) struct Ticks {
    pub(super) task: u16,
    /// So many within the window break it.
    pub(super) ticks: u64,
    /// In nanoseconds.
    pub(super) period: u64,
    pub(super) within: u64,
    /// By number.
    known: IndexSet<Recent>,
    bytes: usize,
    /// Only until the first cycles of all tasks are over.
    pub(super) startup: bool,
    /// It may be broken, if ticks are dated late.
    pub(super) perhaps: bool,
}

impl Ticks {
    pub(super) fn new(task: u16, ticks: u64, (period, within): (u64, u64)) -> Self {
        let known = IndexSet::from([Recent::default()]);
        Self { task, ticks, period, within, known, bytes: 0, startup: false, perhaps: false }
    }

    fn number(&mut self, recent: Recent) -> u32 {
        let size = ENTRY + PIECE + size_of::<Recent>() + 8 * recent.before.len();
        let (at, is_new) = self.known.insert_full(recent);
        self.bytes += if is_new { 2 * size } else { 0 };
        u32::try_from(at).unwrap_or(u32::MAX)
    }

    /// A tick comes, which is missed or not. Returns whether that breaks it.
    fn tick(&mut self, recent: &mut Recent, missed: bool) -> bool {
        let (period, within) = (self.period, self.within);
        recent.before.iter_mut().for_each(|(since, _)| *since += 1);
        // Those before are nearer by up to a period if they were seen when their cycle ended.
        let least = |since: u32| u64::from(since - 1).saturating_mul(period);
        recent.before.retain(|(since, _)| least(*since) < within);
        if !missed {
            return false;
        }
        recent.now += 1;
        let sum = |counts: &dyn Fn(u32) -> bool| {
            let before = recent.before.iter().filter(|(since, _)| counts(*since));
            let before: u64 = before.map(|(_, count)| u64::from(*count)).sum();
            before + u64::from(recent.now)
        };
        let sure = sum(&|since| u64::from(since).saturating_mul(period) <= within);
        self.perhaps |= sum(&|_| true) >= self.ticks;
        if sure >= self.ticks {
            // After that it counts anew; here the first time is enough.
            *recent = Recent::default();
            return true;
        }
        false
    }
}

impl Watch for Ticks {
    fn first(&self, _: &System, _: &State) -> u32 {
        0
    }

    fn longest(&self) -> u64 {
        0
    }

    fn counts(&self, _: &State, _: u32) -> bool {
        false
    }

    fn lead(&mut self, system: &System, step: &Step<'_>) -> Option<Vec<Led>> {
        let next = system.after(step.state, step.action, &mut Vec::new());
        let mut recent = self.known.get_index(step.along as usize)?.clone();
        let mut led = Led::on(next, step.along);
        if step.action == Action::Tick(self.task) {
            let at = step.state.tasks[usize::from(self.task)].at;
            // Also in the start-up, from its first pass on.
            let missed = !matches!(at, At::Absent | At::Sleep);
            led.broken = self.tick(&mut recent, missed).then(|| (self.what(system), None));
            // Some tick is always served, if only at the date at which a cycle ends.
            led.kept = true;
        }
        if ends(system, self.task, step.state, step.action, &led.next) && recent.now > 0 {
            recent.before.push_back((0, std::mem::take(&mut recent.now)));
        }
        led.along = self.number(recent);
        Some(vec![led])
    }

    fn waits(&self, _: &System, _: &State, _: Option<u64>) -> Option<String> {
        None
    }

    fn is_over(&self, state: &State) -> bool {
        let first = |task: &Task| task.young > 0;
        let started = state.phase == Phase::Running && !state.tasks.iter().any(first);
        matches!(state.phase, Phase::Stopping(_)) || state.failed || self.startup && started
    }

    fn bytes(&self) -> usize {
        self.bytes
    }
}

impl Ticks {
    fn what(&self, system: &System) -> String {
        let name = system.task_name(self.task);
        if self.ticks == 1 {
            return format!("{name} is still at work at its tick");
        }
        format!("{name} may miss {} ticks within {}", self.ticks, duration(self.within))
    }
}
