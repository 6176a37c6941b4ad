//! Steps of state machines that must not be taken.

use genom_description::model::{Ix as _, Owner, StateIx};

use super::fires::{Fires, Trace};
use crate::action::Action;
use crate::codels::small;
use crate::explore::Explored;
use crate::state::State;
use crate::system::System;
use genom_timing::Limits;

impl System {
    pub(super) fn takes_step(
        &self,
        owner: Owner,
        (from, to): (StateIx, StateIx),
        limits: &Limits,
    ) -> Fires {
        let (from, to) = (small(from.index()), small(to.index()));
        let is_it = |state: &State, action: Action| {
            self.machine_step(state, action).is_some_and(|(machine, own, next)| {
                let same = self.plan.machines()[usize::from(machine)].owner == owner;
                same && (own, next) == (from, to)
            })
        };
        let mut found = None;
        let explored = Explored::whilst(self, limits, |number, state, enabled: &[Action]| {
            let wrong = enabled.iter().find(|action| is_it(state, **action));
            if let Some(action) = wrong {
                found.get_or_insert((number, state.clone(), *action));
            }
            found.is_none()
        });
        let Some((number, state, action)) = found else {
            return match explored.limit {
                Some(limit) => Fires::Undecided(format!("{limit}: raise the limits")),
                None => Fires::Never,
            };
        };
        let mut run = explored.run_to(self, number);
        run.push((state, action));
        let lines = run.iter().filter_map(|(state, action)| self.words(state, *action));
        let what = format!("it goes from {} to {}", self.state_name(from), self.state_name(to));
        Fires::Can { what, run: Trace::Steps(lines.collect()) }
    }
}
