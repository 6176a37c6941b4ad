//! One pass: a codel for each active place of each run (R6, R7; genom3.md 7.5).

use crate::action::{Answer, End};
use crate::state::{At, Mode, Place, State};
use crate::system::System;
use crate::variant::Variant;

impl System {
    /// R7: goes on to the next ready place from this one on, and enters the node of its codel. `ran`
    /// tells that a codel of this run ran in this pass.
    pub(super) fn go_on(
        &self,
        state: &mut State,
        task: u16,
        mut run: u16,
        mut place: u16,
        mut ran: bool,
    ) {
        let me = &mut state.tasks[usize::from(task)];
        while let Some(current) = me.runs.get_mut(usize::from(run)) {
            if current.end.is_none() {
                let machine = &self.machines[usize::from(current.machine)];
                let mut places = current.places.iter().zip(0u16..).skip(usize::from(place));
                let next = places.find(|(place, _)| place.mode == Mode::Ready);
                if let Some((at, number)) = next {
                    if let Some(codel) = machine.codel(at.state) {
                        me.at = At::Codel { run, place: number };
                        state.lock.enter(&self.conflicts, task, codel);
                        return;
                    }
                    // The codel that yielded this state must not have done so.
                    current.end = Some(End::Failed);
                } else if ran {
                    merge(&mut current.places);
                    if current.places.is_empty() {
                        current.end = Some(End::Success);
                    }
                }
            }
            (run, place, ran) = (run + 1, 0, false);
        }
        me.moved |= me.runs.iter().any(|run| run.end.is_some());
        if me.moved { self.hand_back(state, task) } else { self.rest(state, task) }
    }

    /// R6: what a task executes has ended.
    pub(super) fn task_returns(&self, state: &mut State, task: u16, answer: Answer) {
        let index = usize::from(task);
        let (run, place) = match state.tasks[index].at {
            At::Codel { run, place } => (run, place),
            At::Fetch { run } => {
                state.lock.leave(&self.conflicts, task);
                let me = &mut state.tasks[index];
                let ended = me.runs.remove(usize::from(run));
                me.outbox.push(ended);
                return self.hand_back(state, task);
            }
            _ => return,
        };
        state.lock.leave(&self.conflicts, task);
        let me = &mut state.tasks[index];
        let current = &mut me.runs[usize::from(run)];
        let at = &mut current.places[usize::from(place)];
        *at = match answer {
            Answer::Go(to) if self.by_period && self.periods[index].is_some() => {
                Place { state: to, mode: Mode::Paused }
            }
            Answer::Go(to) if self.variant == Some(Variant::RunToPause) => {
                *at = Place { state: to, mode: Mode::Ready };
                me.moved = true;
                return self.go_on(state, task, run, place, true);
            }
            Answer::Go(to) => {
                (me.again, me.moved) = (true, true);
                Place { state: to, mode: Mode::Ready }
            }
            Answer::Pause(to) => Place { state: to, mode: Mode::Paused },
            Answer::Sleep(to) => Place { state: to, mode: Mode::Asleep },
            Answer::End => Place { state: at.state, mode: Mode::Done },
            Answer::Ok | Answer::Fail => {
                current.end = Some(End::Failed);
                return self.go_on(state, task, run + 1, 0, false);
            }
        };
        self.go_on(state, task, run, place + 1, true);
    }

    /// R8: gives control the runs that ended, in order. Outputs that are in the IDS are read before,
    /// which excludes what writes them.
    fn hand_back(&self, state: &mut State, task: u16) {
        let me = &mut state.tasks[usize::from(task)];
        while let Some(at) = me.runs.iter().position(|run| run.end.is_some()) {
            let run = &me.runs[at];
            let fetch = self.machines[usize::from(run.machine)].fetch;
            if let (Some(End::Success), Some(node)) = (run.end, fetch) {
                me.at = At::Fetch { run: crate::codels::small(at) };
                state.lock.enter(&self.conflicts, task, node);
                return;
            }
            let ended = me.runs.remove(at);
            me.outbox.push(ended);
        }
        if self.wakes_others(Some(task)) {
            me.at = At::Wake;
        } else {
            self.rest(state, task);
        }
    }
}

/// Removes places that have ended, and makes one of those in the same state.
fn merge(places: &mut Vec<Place>) {
    places.retain(|place| place.mode != Mode::Done);
    let mut at = 1;
    while at < places.len() {
        let place = places[at];
        match places[..at].iter_mut().find(|other| other.state == place.state) {
            Some(other) => {
                other.mode = other.mode.max(place.mode);
                places.remove(at);
            }
            None => at += 1,
        }
    }
}
