//! What control does with ended runs (R9; genom3.md 7.5, "Ends").

use crate::action::{End, Told};
use crate::state::{Life, Run, State};
use crate::system::System;

impl System {
    /// R9: clients are told, slots are freed, and what waited for an end may start.
    pub(super) fn collect(&self, state: &mut State, task: Option<u16>, told: &mut Vec<Told>) {
        let all = 0..state.tasks.len();
        for at in all.filter(|at| task.is_none_or(|task| usize::from(task) == *at)) {
            for run in std::mem::take(&mut state.tasks[at].outbox) {
                self.collected(state, &run, told);
            }
        }
        self.examine(state, told);
    }

    fn collected(&self, state: &mut State, run: &Run, told: &mut Vec<Told>) {
        let end = run.end.unwrap_or(End::Success);
        let Some(service) = self.service_of(run) else {
            state.failed |= end == End::Failed;
            // R15: it was asked to stop, and did not get there.
            let machine = &self.machines[usize::from(run.machine)];
            let (task, stops) = (machine.task, machine.codel(machine.stop).is_some());
            if run.asked && run.life == Life::Run && stops {
                self.send_permanent(state, task, true);
                self.wake(state, task);
            }
            return;
        };
        if run.life == Life::Cancelled {
            // Its client was told when it was stopped.
            return;
        }
        if end == End::Success {
            self.executed(state, service);
        }
        told.push(Told::Ended(run.number, end));
    }

    /// A service was executed, which `before` and `after` look at (genom3.md 7.6).
    pub(super) fn executed(&self, state: &mut State, service: u16) {
        if self.services[usize::from(service)].ordered
            && let Err(at) = state.ran.binary_search(&service)
        {
            state.ran.insert(at, service);
        }
    }
}
