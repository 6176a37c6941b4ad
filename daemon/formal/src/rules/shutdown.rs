//! Start-up and shutdown (R1, R14, R15; genom3.md 7.2, 7.7).

use crate::action::{End, Told};
use crate::codels::small;
use crate::rules::activities::{runs_of, stop};
use crate::state::{At, Phase, State, Step};
use crate::system::System;

impl System {
    /// R1: tasks start in order of declaration, each when the first pass of the one before is over.
    pub(super) fn start(&self, state: &mut State) {
        let Phase::Starting(task) = state.phase else { return };
        self.send_permanent(state, task, false);
        state.tasks[usize::from(task)].at = At::Begin { tick: true };
    }

    /// R1, R15: the next step of the start-up, or of the shutdown.
    pub(super) fn advance(&self, state: &mut State, told: &mut Vec<Told>) {
        match state.phase {
            Phase::Starting(task) => {
                self.collect(state, None, told);
                if state.failed {
                    return self.kill(state, told);
                }
                let last = usize::from(task) + 1 == state.tasks.len();
                state.phase = if last { Phase::Running } else { Phase::Starting(task + 1) };
            }
            Phase::Stopping(step) => {
                let next = match step {
                    Step::Activities => state.tasks.len(),
                    Step::Permanent(task) => usize::from(task),
                };
                match next.checked_sub(1) {
                    Some(task) => {
                        let task = small(task);
                        state.phase = Phase::Stopping(Step::Permanent(task));
                        self.stop_permanent(state, task);
                    }
                    None => state.phase = Phase::Stopped,
                }
            }
            Phase::Running | Phase::Stopped => {}
        }
    }

    /// Whether the start-up or the shutdown can take its next step.
    pub(crate) fn advances(&self, state: &State) -> bool {
        match state.phase {
            Phase::Starting(task) => {
                let task = &state.tasks[usize::from(task)];
                task.at != At::Absent && task.young < 2
            }
            Phase::Stopping(Step::Activities) => {
                let runs = state.tasks.iter().flat_map(runs_of);
                runs.filter_map(|run| self.service_of(run)).next().is_none()
                    && state.workers.is_empty()
            }
            Phase::Stopping(Step::Permanent(task)) => {
                runs_of(&state.tasks[usize::from(task)]).next().is_none()
            }
            Phase::Running | Phase::Stopped => false,
        }
    }

    /// R15: activities of services are asked to stop; no new ones are accepted.
    pub(super) fn kill(&self, state: &mut State, told: &mut Vec<Told>) {
        state.phase = Phase::Stopping(Step::Activities);
        for pending in std::mem::take(&mut state.pending) {
            told.push(Told::Ended(pending.number, End::Interrupted));
        }
        for task in &mut state.tasks {
            let runs = task.runs.iter_mut().chain(&mut task.inbox);
            let services =
                runs.filter(|run| self.machines[usize::from(run.machine)].service.is_some());
            services.for_each(|run| {
                stop(run, told);
            });
        }
        self.wake_all(state);
    }

    /// R15: a permanent activity is asked to stop. One that has ended begins again in `stop`, here if
    /// it was collected, otherwise when it is.
    fn stop_permanent(&self, state: &mut State, task: u16) {
        let me = &mut state.tasks[usize::from(task)];
        let machine = &self.machines[usize::from(self.permanent(task))];
        if runs_of(me).next().is_some() {
            let runs = me.runs.iter_mut().chain(&mut me.inbox).chain(&mut me.outbox);
            runs.for_each(|run| run.asked = true);
        } else if me.at != At::Absent && machine.codel(machine.stop).is_some() {
            self.send_permanent(state, task, true);
        }
        self.wake(state, task);
    }

    /// R15: what a shutdown asks of a periodic task need not wait for its tick.
    pub(super) fn hurry(&self, state: &mut State, task: u16) {
        state.tasks[usize::from(task)].at = At::Begin { tick: true };
    }

    /// R14: an external event reaches a task; the sink is an index into the model's list.
    pub(super) fn fire(&self, state: &mut State, task: u16, sink: u16) {
        let me = &mut state.tasks[usize::from(task)];
        if let Err(at) = me.fired.binary_search(&sink) {
            me.fired.insert(at, sink);
        }
        self.wake(state, task);
    }
}
