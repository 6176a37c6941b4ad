//! Cycles of a task, each from its own beginning.

use genom_timing::duration;

use super::clocked::{Led, Step, Watch};
use crate::action::Action;
use crate::state::{At, Phase, State};
use crate::system::System;

/// The task that does something by a step.
fn of_task(system: &System, action: Action) -> Option<u16> {
    match action {
        Action::Begin(task) | Action::Wake(task) => Some(task),
        Action::Return(context, _) => Some(context).filter(|context| system.is_task(*context)),
        _ => None,
    }
}

/// Whether a step ends a cycle of this periodic task: nothing is left to do, or a tick was kept.
pub(super) fn ends(
    system: &System,
    task: u16,
    state: &State,
    action: Action,
    next: &State,
) -> bool {
    let at = |state: &State| state.tasks[usize::from(task)].at;
    let works = !matches!(at(state), At::Absent | At::Sleep);
    let over = matches!(at(next), At::Sleep | At::Begin { tick: true });
    works && over && of_task(system, action) == Some(task)
}

/// The cycles of a task that begin after the start-up.
pub(super) struct Cycles {
    pub(super) task: u16,
    /// In nanoseconds.
    pub(super) limit: u64,
}

/// Of what goes along: a cycle lasts that counts.
const LASTS: u32 = 1;
/// And: the start-up is over, so that cycles that begin count.
const OPEN: u32 = 2;

impl Watch for Cycles {
    fn first(&self, _: &System, state: &State) -> u32 {
        if state.phase == Phase::Running { OPEN } else { 0 }
    }

    fn longest(&self) -> u64 {
        self.limit.saturating_add(1)
    }

    fn counts(&self, _: &State, along: u32) -> bool {
        along & LASTS > 0
    }

    fn lead(&mut self, system: &System, step: &Step<'_>) -> Option<Vec<Led>> {
        let next = system.after(step.state, step.action, &mut Vec::new());
        let ends = ends(system, self.task, step.state, step.action, &next);
        let at = |state: &State| state.tasks[usize::from(self.task)].at;
        let sleeps = matches!(at(step.state), At::Absent | At::Sleep);
        let begins = at(&next) == At::Begin { tick: true } && (ends || sleeps);
        let opens = if next.phase == Phase::Running { OPEN } else { 0 };
        let mut led = Led::on(next, step.along | opens);
        if ends {
            // One that takes too long breaks it while it lasts. One in which nothing is to be done ends
            // as it begins, and says nothing of the limit.
            let counts = led.along & LASTS > 0 && !matches!(step.action, Action::Begin(_));
            led.kept = counts && step.within(self.limit);
            led.along &= OPEN;
        }
        if begins && led.along & OPEN > 0 {
            led.along |= LASTS;
            led.anew = true;
        }
        Some(vec![led])
    }

    fn waits(&self, system: &System, _: &State, time: Option<u64>) -> Option<String> {
        let late = time.is_none_or(|time| time > self.limit);
        late.then(|| {
            let (name, limit) = (system.task_name(self.task), duration(self.limit));
            format!("a cycle of task {name} may take longer than {limit}")
        })
    }
}
