//! What would have to change so that a task is in time.

use super::known::Cause;
use super::report::{Processors, Schedule};
use crate::codels::small;
use crate::system::System;
use crate::timed::Times;
use genom_timing::below;

impl System {
    /// Finds the codels of which a shorter time would do, each by itself.
    pub(super) fn advise(
        &self,
        schedule: &mut Schedule,
        times: &Times,
        processors: Processors,
        late: u64,
    ) {
        for at in 0..schedule.tasks.len() {
            if !matches!(schedule.tasks[at].response, Err(Cause::Late(_))) {
                continue;
            }
            let holds = |codel: u16, most: u64| {
                let other = self.bounded(&times.with_most(codel, most), processors, late);
                other.tasks.get(at).is_some_and(|task| task.response.is_ok())
            };
            let codels = 0..small(self.codels.len());
            let bound = |codel: u16| {
                let duration = times.of(codel);
                let found = below(duration.least, duration.most?, |most| holds(codel, most))?;
                Some((self.node_name(codel), found))
            };
            schedule.tasks[at].needed = codels.filter_map(bound).collect();
        }
    }
}
