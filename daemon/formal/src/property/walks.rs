//! Random runs, which show what can happen.

use genom_timing::Random;

use crate::action::Action;
use crate::state::{Phase, State};
use crate::system::System;

/// Steps of all runs.
const STEPS: usize = 100_000;
/// Steps of one run.
const RUN: usize = 2_000;

/// Shows the states of random runs to `look`, for as long as it returns `true`.
pub(super) fn walks(system: &System, mut look: impl FnMut(&State) -> bool) {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut state, mut steps, mut told) = (system.initial(false), 0, Vec::new());
    for _ in 0..STEPS {
        if !look(&state) {
            return;
        }
        // What ends a run or an activity is one step of many: it is taken less often.
        let seldom = |action: &Action| match action {
            Action::Kill => RUN / 2,
            Action::Abort(..) => 20,
            _ => 0,
        };
        let mut actions = system.enabled(&state);
        actions.retain(|action| random.below(seldom(action)) == 0);
        if actions.is_empty() || state.phase == Phase::Stopped || steps == RUN {
            (state, steps) = (system.initial(false), 0);
            continue;
        }
        let action = actions[random.below(actions.len())];
        state = system.after(&state, action, &mut told);
        told.clear();
        steps += 1;
    }
}
