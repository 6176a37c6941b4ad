//! Random runs, with all dates at once, that look for a tick that comes while its task is at work.

use std::time::{Duration, Instant};

use super::clocks::{guarded, initial, stepped};
use super::explore::Timed;
use super::times::Times;
use crate::action::Action;
use crate::state::State;
use crate::system::System;

/// Steps of a run.
const STEPS: usize = 400;
/// Tries to take a step that the clocks allow.
const TRIES: usize = 20;
/// Time for all runs.
const TIME: Duration = Duration::from_secs(2);

/// A generator of numbers; the same ones each time (xorshift64, Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).unwrap_or(0) % count.max(1)
    }
}

/// A run in which this task is late, if one is met.
pub(crate) fn walk(system: &System, times: &Times, task: u16) -> Option<Vec<(State, Action)>> {
    let begin = Instant::now();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    while begin.elapsed() < TIME {
        if let Some(run) = one(system, times, task, &mut random) {
            return Some(run);
        }
    }
    None
}

fn one(
    system: &System,
    times: &Times,
    task: u16,
    random: &mut Random,
) -> Option<Vec<(State, Action)>> {
    let (mut run, mut told) = (Vec::new(), Vec::new());
    let mut state = system.initial(false);
    let mut zone = initial(system, times, &state)?;
    for _ in 0..STEPS {
        let tick = Action::Tick(task);
        if Timed::is_late(&state, tick).is_some()
            && guarded(system, times, &state, &zone, tick).is_some()
        {
            run.push((state, tick));
            return Some(run);
        }
        let mut actions = system.timed(&state);
        // Every other step a request, if one is possible: a codel may wait for each.
        let requests = |action: &Action| matches!(action, Action::Request(_));
        if random.below(2) == 0 && actions.iter().any(requests) {
            actions.retain(requests);
        }
        let next = (0..TRIES).find_map(|_| {
            let action = *actions.get(random.below(actions.len()))?;
            // Aborts and events are many; work is what takes time.
            let seldom = matches!(action, Action::Abort(..) | Action::Fire(..));
            if seldom && random.below(8) > 0 {
                return None;
            }
            let before = guarded(system, times, &state, &zone, action)?;
            let next = system.after(&state, action, &mut told);
            told.clear();
            let after = stepped(system, times, (&state, &before), action, &next)?;
            Some((action, next, after))
        });
        let (action, next, after) = next?;
        run.push((std::mem::replace(&mut state, next), action));
        zone = after;
    }
    None
}
