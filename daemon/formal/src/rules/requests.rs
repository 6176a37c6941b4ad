//! Requests and their workers (R10, R11; genom3.md 7.3).

use crate::action::{Answer, End, Told};
use crate::rules::activities::{insert, new_run};
use crate::services::Work;
use crate::state::{Life, Pc, Pending, Phase, State};
use crate::system::System;

impl System {
    /// R10: a request needs a slot of its task, and the order that `before` and `after` ask for.
    pub(super) fn request(&self, state: &mut State, service: u16, told: &mut Vec<Told>) {
        let facts = &self.services[usize::from(service)];
        let task = facts.machine.map(|machine| self.machines[usize::from(machine)].task);
        let slot = task.is_none_or(|task| self.used(state, task) < self.bounds.slots);
        let ran = |other: &u16| state.ran.binary_search(other).is_ok();
        let order = facts.after.iter().all(ran) && !facts.before.iter().any(ran);
        insert(state, service);
        if slot && order {
            self.work(state, service, 0, told);
        } else {
            self.finish(state, service, false, told);
        }
    }

    /// R11: enters the node of the next item of work, or finishes.
    fn work(&self, state: &mut State, service: u16, item: u16, told: &mut Vec<Told>) {
        let work = self.services[usize::from(service)].work.get(usize::from(item));
        match work {
            None => self.finish(state, service, true, told),
            Some(work) => {
                set(state, service, Pc::Work(item));
                if let Work::Codel(node) | Work::Transfer(node) = *work {
                    state.lock.enter(&self.conflicts, self.worker_context(service), node);
                }
            }
        }
    }

    /// R6: what a worker executes has ended.
    pub(super) fn worker_returns(
        &self,
        state: &mut State,
        context: u16,
        answer: Answer,
        told: &mut Vec<Told>,
    ) {
        let service = context - self.worker_context(0);
        let Some(Pc::Work(item)) = self.pc(state, service) else { return };
        state.lock.leave(&self.conflicts, context);
        match answer {
            Answer::Ok => self.work(state, service, item + 1, told),
            _ => self.finish(state, service, false, told),
        }
    }

    /// R11: the work of a request is done, or it is refused. Tasks that wait for anything to happen
    /// are woken in either case.
    pub(super) fn finish(&self, state: &mut State, service: u16, ok: bool, told: &mut Vec<Told>) {
        let facts = &self.services[usize::from(service)];
        // An abort that wakes nobody has nothing more to do.
        let over = facts.work.first() == Some(&Work::Abort) && !facts.ordered;
        match (self.wakes_others(None), ok) {
            (false, true) if over => answer(state, service, End::Success, told),
            (true, _) => set(state, service, Pc::Wake(ok)),
            (false, true) => set(state, service, Pc::Conclude),
            (false, false) => answer(state, service, End::Failed, told),
        }
    }

    /// R11: wakes the tasks; then an activity is accepted, any other service interrupts and is over.
    pub(super) fn proceed(&self, state: &mut State, service: u16, told: &mut Vec<Told>) {
        match self.pc(state, service) {
            Some(Pc::Wake(ok)) => {
                self.wake_all(state);
                if ok {
                    set(state, service, Pc::Conclude);
                } else {
                    answer(state, service, End::Failed, told);
                }
            }
            Some(Pc::Conclude) if self.services[usize::from(service)].machine.is_some() => {
                state.workers.retain(|worker| worker.service != service);
                self.accept(state, service, told);
            }
            Some(Pc::Conclude) => {
                self.executed(state, service);
                let mut gone = vec![false; state.pending.len()];
                self.interrupt(state, service, None, &mut gone, told);
                let mut at = 0..gone.len();
                state.pending.retain(|_| at.next().is_none_or(|at| !gone[at]));
                self.examine(state, told);
                answer(state, service, End::Success, told);
            }
            Some(Pc::Work(_)) | None => {}
        }
    }

    fn accept(&self, state: &mut State, service: u16, told: &mut Vec<Told>) {
        let number = number(state);
        told.push(Told::Accepted(number));
        if state.phase == Phase::Running {
            state.pending.push(Pending { service, number });
            self.examine(state, told);
        } else {
            // During a shutdown nothing starts any more, but the client is answered as usual.
            told.push(Told::Ended(number, End::Interrupted));
        }
    }

    /// Sends a permanent activity to its task (R1), or one that only stops (R15).
    pub(super) fn send_permanent(&self, state: &mut State, task: u16, at_stop: bool) {
        let run = new_run(self.permanent(task), number(state), at_stop);
        debug_assert_eq!(run.life, Life::Init);
        state.tasks[usize::from(task)].inbox.push(run);
    }

    pub(crate) fn pc(&self, state: &State, service: u16) -> Option<Pc> {
        let at = state.workers.binary_search_by_key(&service, |worker| worker.service).ok()?;
        Some(state.workers[at].pc)
    }
}

fn set(state: &mut State, service: u16, pc: Pc) {
    let worker = state.workers.iter_mut().find(|worker| worker.service == service);
    worker.into_iter().for_each(|worker| worker.pc = pc);
}

/// The request is over.
fn answer(state: &mut State, service: u16, end: End, told: &mut Vec<Told>) {
    state.workers.retain(|worker| worker.service != service);
    told.push(Told::Answered(service, end));
}

/// The number of a new activity.
fn number(state: &mut State) -> u32 {
    let number = state.next;
    state.next += u32::from(number > 0);
    number
}
