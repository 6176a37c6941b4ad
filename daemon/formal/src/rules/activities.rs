//! Stop requests and starts of activities (R12, R13; genom3.md 7.5, 7.6).

use crate::action::{End, Target, Told};
use crate::state::{Life, Pc, Run, State, Worker};
use crate::system::System;

impl System {
    /// Number of activities of a service that were accepted and not collected.
    pub(crate) fn instances(&self, state: &State, service: u16) -> usize {
        let runs = state.tasks.iter().flat_map(runs_of);
        runs.filter(|run| self.service_of(run) == Some(service)).count()
            + state.pending.iter().filter(|pending| pending.service == service).count()
    }

    /// Slots of a task that activities and requests for them have.
    pub(crate) fn used(&self, state: &State, task: u16) -> usize {
        let of_task = |service: u16| {
            let machine = self.services[usize::from(service)].machine;
            machine.is_some_and(|machine| self.machines[usize::from(machine)].task == task)
        };
        let me = &state.tasks[usize::from(task)];
        runs_of(me).filter(|run| self.service_of(run).is_some()).count()
            + state.pending.iter().filter(|pending| of_task(pending.service)).count()
            + state
                .workers
                .iter()
                .filter(|worker| worker.pc != Pc::Wake(false) && of_task(worker.service))
                .count()
    }

    pub(crate) fn service_of(&self, run: &Run) -> Option<u16> {
        self.machines[usize::from(run.machine)].service
    }

    /// R12: the activities that a service interrupts are asked to stop. Of the pending ones, which
    /// vanish, the one at `but` is spared. `gone` marks pending ones that have vanished.
    pub(super) fn interrupt(
        &self,
        state: &mut State,
        service: u16,
        but: Option<usize>,
        gone: &mut [bool],
        told: &mut Vec<Told>,
    ) {
        let interrupts = &self.services[usize::from(service)].interrupts;
        for (at, pending) in state.pending.iter().enumerate() {
            let meant = Some(at) != but && interrupts[usize::from(pending.service)];
            if meant && !std::mem::replace(&mut gone[at], true) {
                told.push(Told::Ended(pending.number, End::Interrupted));
            }
        }
        for task in 0..state.tasks.len() {
            let me = &mut state.tasks[task];
            let runs = me.runs.iter_mut().chain(&mut me.inbox);
            let meant = |run: &&mut Run| {
                let service = self.machines[usize::from(run.machine)].service;
                service.is_some_and(|service| interrupts[usize::from(service)])
            };
            let mut changed = false;
            runs.filter(meant).for_each(|run| changed |= stop(run, told));
            if changed {
                self.wake(state, crate::codels::small(task));
            }
        }
    }

    /// R12: the newest pending activities stop first what they interrupt; then those start, oldest
    /// first, that wait for nothing that was started and not collected.
    pub(super) fn examine(&self, state: &mut State, told: &mut Vec<Told>) {
        let mut gone = vec![false; state.pending.len()];
        for at in (0..gone.len()).rev() {
            if !gone[at] {
                let service = state.pending[at].service;
                self.interrupt(state, service, Some(at), &mut gone, told);
            }
        }
        let mut at = 0..gone.len();
        state.pending.retain(|_| at.next().is_none_or(|at| !gone[at]));
        for pending in std::mem::take(&mut state.pending) {
            let interrupts = &self.services[usize::from(pending.service)].interrupts;
            let blocks = |run: &Run| {
                let service = self.service_of(run);
                matches!(run.life, Life::Run | Life::Stop)
                    && service.is_some_and(|service| interrupts[usize::from(service)])
            };
            let Some(machine) = self.services[usize::from(pending.service)].machine else {
                continue;
            };
            if state.tasks.iter().flat_map(runs_of).any(blocks) {
                state.pending.push(pending);
                continue;
            }
            let task = self.machines[usize::from(machine)].task;
            state.tasks[usize::from(task)].inbox.push(new_run(machine, pending.number, false));
            self.wake(state, task);
        }
    }

    /// R13: asks one activity to stop. The request for that and its effect may be one step.
    pub(super) fn abort(
        &self,
        state: &mut State,
        service: u16,
        target: Target,
        told: &mut Vec<Told>,
    ) {
        if self.pc(state, service).is_none() {
            insert(state, service);
        }
        let task_of = |task: u16| usize::from(task);
        let found = match target {
            Target::Nobody => false,
            Target::Pending(at) => {
                let pending = state.pending.remove(usize::from(at));
                told.push(Told::Ended(pending.number, End::Interrupted));
                true
            }
            Target::Sent(task, at) => {
                stop(&mut state.tasks[task_of(task)].inbox[usize::from(at)], told);
                self.wake(state, task);
                true
            }
            Target::Runs(task, at) => {
                stop(&mut state.tasks[task_of(task)].runs[usize::from(at)], told);
                self.wake(state, task);
                true
            }
        };
        if found {
            self.examine(state, told);
        }
        self.finish(state, service, found, told);
    }
}

/// A worker begins to serve a request.
pub(super) fn insert(state: &mut State, service: u16) {
    let at = state.workers.partition_point(|worker| worker.service < service);
    state.workers.insert(at, Worker { service, pc: Pc::Work(0) });
}

/// A run that was sent to its task.
pub(super) fn new_run(machine: u16, number: u32, at_stop: bool) -> Run {
    let life = Life::Init;
    Run { machine, life, at_stop, asked: false, places: Vec::new(), end: None, number }
}

/// All runs that a task has and that control has not collected.
pub(crate) fn runs_of(task: &crate::state::Task) -> impl Iterator<Item = &Run> {
    task.runs.iter().chain(&task.inbox).chain(&task.outbox)
}

/// R12: one that has not begun never will; one that runs is asked. A second request changes
/// nothing. Returns whether this one did.
pub(super) fn stop(run: &mut Run, told: &mut Vec<Told>) -> bool {
    match run.life {
        Life::Init => {
            run.life = Life::Cancelled;
            told.push(Told::Ended(run.number, End::Interrupted));
            true
        }
        Life::Run if !run.asked && run.end.is_none() => {
            run.asked = true;
            true
        }
        Life::Run | Life::Stop | Life::Cancelled => false,
    }
}
