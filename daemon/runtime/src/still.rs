//! Holds a component still: all tasks between two passes, and no codel running.

use std::time::{Duration, Instant};

use genom_description::model::{Indexed, TaskIx};

use crate::engine::Engine;
use crate::exclusion::Permit;
use crate::lock::Guard;
use crate::shared::TaskShared;
use crate::task::driven::DrivenTask;
use crate::task::gate::Held;

/// Pause between two attempts: nobody is kept waiting by one that fails.
pub(crate) const LOOK: Duration = Duration::from_micros(500);

/// Longest time for which one attempt waits for a task, so that callers hear of codels that are
/// stuck.
const ONE_PASS: Duration = Duration::from_millis(5);

/// Keeps codels from running, async ones included, until it is dropped.
pub(crate) struct Still<'a> {
    /// The insides of all tasks, in their order. Runs that control had sent are admitted.
    pub(crate) tasks: Vec<Held<'a>>,
    _permit: Permit<'a>,
    _one: Guard<'a, ()>,
    _driven: Option<Guard<'a, Vec<DrivenTask>>>,
}

impl Still<'_> {
    /// Date until which each periodic task has served its ticks, or missed them; and whether none
    /// that is due at date `now` is left.
    pub(crate) fn served(&self, tasks: &Indexed<TaskIx, TaskShared>, now: u64) -> (u64, bool) {
        let last = tasks.iter().zip(&self.tasks).filter_map(|(task, inside)| {
            let timing = task.timing?;
            (timing.count(inside.passed) < timing.count(now)).then_some(inside.passed)
        });
        last.min().map_or((now, true), |earliest| (earliest, false))
    }
}

impl Engine {
    /// `None` if a codel runs.
    pub(crate) fn try_still(&self) -> Option<Still<'_>> {
        // On a virtual clock: no step is under way in this instance.
        let driven = match &self.driven {
            Some(driven) => Some(driven.try_lock().ok()?),
            None => None,
        };
        let one = self.everything.try_lock().ok()?;
        // Of tasks that make a pass, one is waited for while no other is kept from its own: it may
        // hardly ever be between two passes by chance.
        let all: Vec<_> = self.gates.iter().map(|gate| gate.try_lock()).collect();
        let all = match all.iter().position(Option::is_none) {
            None => all,
            Some(busy) => {
                drop(all);
                let task = self.shared.tasks.places().nth(busy)?;
                let mut waited = Some(self.gates[task].lock_until(Instant::now() + ONE_PASS)?);
                let others = self.gates.pairs();
                others
                    .map(
                        |(other, gate)| if other == task { waited.take() } else { gate.try_lock() },
                    )
                    .collect()
            }
        };
        let mut tasks: Vec<_> = all.into_iter().collect::<Option<_>>()?;
        let outside = self.shared.outside_context();
        let permit = self.shared.exclusion.stand_still(outside, Some(Duration::ZERO))?;
        tasks.iter_mut().for_each(|inside| inside.admit_sent());
        Some(Still { tasks, _permit: permit, _one: one, _driven: driven })
    }
}
