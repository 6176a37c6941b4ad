//! Activities that take too long: from their acceptance until their client is answered, or from when
//! they were asked to stop.

use std::time::Duration;

use genom_description::model::{Ix as _, ServiceIx};
use genom_runtime::nanos;
use genom_timing::{Limits, duration};

use super::clocked::{Led, Step, Watch};
use super::fires::Fires;
use crate::action::{Action, End, Told};
use crate::codels::small;
use crate::state::State;
use crate::system::System;
use crate::timed::{Follow, Over, Times, accepts, after_into, forget, number, over, running};

/// Follows one activity of a service at a time, any of them.
struct Waiting {
    service: u16,
    /// From when it was asked to stop; else from its acceptance.
    asked: bool,
    /// In nanoseconds.
    limit: u64,
}

impl Waiting {
    fn follows(&self, system: &System, state: &State, action: Action) -> Vec<Follow> {
        let mut all = vec![Follow::None];
        if number(state).is_some() {
            return all;
        }
        // A shutdown asks as well.
        let asks = matches!(
            action,
            Action::Proceed(_) | Action::Abort(..) | Action::Collect(_) | Action::Kill
        );
        if self.asked && asks {
            let own = running(system, state).filter(|(_, service)| *service == self.service);
            all.extend(own.map(|(follow, _)| follow));
        }
        if !self.asked && accepts(system, state, action) == Some(self.service) {
            all.push(Follow::Accepted);
        }
        all
    }
}

impl Watch for Waiting {
    fn first(&self, _: &System, _: &State) -> u32 {
        0
    }

    fn longest(&self) -> u64 {
        self.limit.saturating_add(1)
    }

    fn counts(&self, state: &State, _: u32) -> bool {
        number(state).is_some()
    }

    fn lead(&mut self, system: &System, step: &Step<'_>) -> Option<Vec<Led>> {
        let led = |follow: Follow| {
            let (mut next, mut told) = (step.state.clone(), Vec::new());
            after_into(system, (&mut next, step.state), step.action, follow, &mut told);
            let own = number(step.state);
            let over = over(system, step.state, &next, &told);
            let ended = matches!(over, Some((_, Over::Ended | Over::Gone)));
            if ended {
                forget(&mut next);
            }
            // One that fails, or is cancelled before it begins, says nothing of the limit.
            let counts = told.iter().any(|told| match told {
                Told::Ended(number, End::Success) => own == Some(*number),
                Told::Ended(number, End::Interrupted) => self.asked && own == Some(*number),
                _ => false,
            });
            // One that takes too long breaks it while it lasts.
            Led { kept: ended && counts && step.within(self.limit), ..Led::on(next, 0) }
        };
        Some(self.follows(system, step.state, step.action).into_iter().map(led).collect())
    }

    fn is_over(&self, _: &State) -> bool {
        // A shutdown waits for activities, and asks them to stop.
        false
    }

    fn waits(&self, system: &System, _: &State, time: Option<u64>) -> Option<String> {
        let late = time.is_none_or(|time| time > self.limit);
        let to = if self.asked { " to its end after it was asked to stop" } else { "" };
        late.then(|| {
            let (name, limit) = (system.service_name(self.service), duration(self.limit));
            format!("activity {name} may take longer than {limit}{to}")
        })
    }
}

impl System {
    /// Activities of a service that take longer; `asked` for the time since they were asked to stop.
    pub(super) fn waiting(
        &self,
        (service, asked): (ServiceIx, bool),
        longest: Duration,
        times: Result<&Times, &str>,
        limits: &Limits,
    ) -> Fires {
        let service = small(service.index());
        let mut waiting = Waiting { service, asked, limit: nanos(longest) };
        // Only what matters to it.
        let parts = self.parts_of_activities();
        let own = parts.iter().find(|part| {
            let of_service = part.services[usize::from(service)].machine;
            let task = of_service.map(|machine| part.machines[usize::from(machine)].task);
            part.clients[usize::from(service)] && task.is_some_and(|task| part.is_looked_at(task))
        });
        own.unwrap_or(self).clocked(&mut waiting, times, limits)
    }
}
