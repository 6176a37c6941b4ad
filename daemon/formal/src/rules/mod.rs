//! The rules: what each step changes. `docs/verify.md` has them as a table.
//!
//! A step is only applied in a state that enables it ([`System::enabled`]); in any other state it
//! changes nothing.

mod activities;
mod collect;
mod pass;
mod prepare;
mod requests;
mod shutdown;
mod task;

pub(crate) use activities::runs_of;

use crate::action::{Action, Told};
use crate::state::State;
use crate::system::System;

impl System {
    /// The state after a step. Adds what clients are told by it to `told`.
    #[must_use]
    pub fn after(&self, state: &State, action: Action, told: &mut Vec<Told>) -> State {
        let mut next = state.clone();
        self.apply(&mut next, action, told);
        next
    }

    /// The same, into the memory of a state that is no longer wanted.
    pub(crate) fn after_into(
        &self,
        next: &mut State,
        state: &State,
        action: Action,
        told: &mut Vec<Told>,
    ) {
        next.clone_from(state);
        self.apply(next, action, told);
    }

    fn apply(&self, state: &mut State, action: Action, told: &mut Vec<Told>) {
        match action {
            Action::Start => self.start(state),
            Action::Advance => self.advance(state, told),
            Action::Tick(task) => self.tick(state, task),
            Action::Hurry(task) => self.hurry(state, task),
            Action::Begin(task) => self.begin(state, task),
            Action::Wake(task) => self.wake_others(state, task),
            Action::Return(context, answer) if self.is_task(context) => {
                self.task_returns(state, context, answer);
            }
            Action::Return(context, answer) => self.worker_returns(state, context, answer, told),
            Action::Collect(task) => self.collect(state, task, told),
            Action::Request(service) => self.request(state, service, told),
            Action::Proceed(service) => self.proceed(state, service, told),
            Action::Abort(service, target) => self.abort(state, service, target, told),
            Action::Fire(task, sink) => self.fire(state, task, sink),
            Action::Kill => self.kill(state, told),
        }
    }
}
