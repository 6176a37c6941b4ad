//! When a task makes a pass (R2, R3, R8; genom3.md 7.4).

use crate::state::{At, State};
use crate::system::System;

impl System {
    /// R2: a tick begins a cycle, or is kept until the present one ends.
    pub(super) fn tick(&self, state: &mut State, task: u16) {
        let task = &mut state.tasks[usize::from(task)];
        match task.at {
            At::Absent => {}
            At::Sleep => task.at = At::Begin { tick: true },
            _ => task.late = true,
        }
    }

    /// R3: a pass takes in what was sent and fired, prepares each run, and looks for a codel.
    pub(super) fn begin(&self, state: &mut State, task: u16) {
        let me = &mut state.tasks[usize::from(task)];
        let tick = match me.at {
            At::Begin { tick } => tick,
            _ => true,
        };
        me.runnable = false;
        let sent = std::mem::take(&mut me.inbox);
        me.runs.extend(sent);
        let fired = std::mem::take(&mut me.fired);
        if me.runs.is_empty() {
            return self.rest(state, task);
        }
        for run in &mut me.runs {
            // Events first: they affect activities that were active when they were fired.
            fired.iter().for_each(|sink| self.receive(run, self.sinks[usize::from(*sink)]));
            self.prepare(run, tick);
        }
        self.go_on(state, task, 0, 0, false);
    }

    /// R8: others may wait for what moved or ended.
    pub(super) fn wake_others(&self, state: &mut State, task: u16) {
        if self.variant != Some(crate::Variant::LostWakeUp) {
            for (other, at) in state.tasks.iter_mut().zip(0u16..) {
                other.runnable |= at != task && self.is_aperiodic(at) && other.at != At::Absent;
            }
        }
        self.rest(state, task);
    }

    /// Something happened that tasks wait for: those without a period make a pass.
    pub(super) fn wake_all(&self, state: &mut State) {
        for (task, at) in state.tasks.iter_mut().zip(0u16..) {
            task.runnable |= self.is_aperiodic(at) && task.at != At::Absent;
        }
    }

    /// Something happened that this task waits for.
    pub(super) fn wake(&self, state: &mut State, task: u16) {
        state.tasks[usize::from(task)].runnable |= self.is_aperiodic(task);
    }

    /// R8: the end of a pass. A cycle goes on at once after a yield without pause; a tick that came
    /// meanwhile is served at once; a task without period goes on when something moved.
    pub(super) fn rest(&self, state: &mut State, task: u16) {
        let aperiodic = self.is_aperiodic(task);
        let me = &mut state.tasks[usize::from(task)];
        let (again, moved) = (std::mem::take(&mut me.again), std::mem::take(&mut me.moved));
        let tick = aperiodic || !again;
        me.young = if again { me.young.min(1) } else { 0 };
        me.at = if again || (aperiodic && moved) || std::mem::take(&mut me.late) && tick {
            At::Begin { tick }
        } else {
            At::Sleep
        };
    }
}
