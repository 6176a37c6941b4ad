//! A task of an instance on a virtual clock: without thread, run by the one that steps the clock.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::task::core::Passed;
use crate::task::runner::Runner;

/// A task without thread.
pub(crate) struct DrivenTask {
    runner: Runner,
    /// Result of the last pass.
    last: Passed,
    /// Date of the next tick, for a periodic task.
    pub(crate) next: Option<u64>,
    /// A tick is pending: it came while the task was still at work, or a shutdown asks for it.
    pub(crate) latched: AtomicBool,
}

impl DrivenTask {
    pub(crate) fn new(runner: Runner) -> Self {
        let now = runner.shared().clock.now();
        let next = runner.shared().tasks[runner.task()].timing.map(|timing| timing.after(now));
        Self { runner, last: Passed::default(), next, latched: AtomicBool::new(false) }
    }

    /// The first pass, at start-up.
    pub(crate) fn start(&mut self, now: u64) {
        let shared = self.runner.shared();
        shared.tasks[self.runner.task()].take_runnable();
        self.last = self.runner.pass(true, now);
    }

    /// Makes one pass if one is due; returns whether it did.
    pub(crate) fn run(&mut self, now: u64) -> bool {
        let shared = std::sync::Arc::clone(self.runner.shared());
        let me = &shared.tasks[self.runner.task()];
        let Some(timing) = me.timing else {
            if !self.last.again && !self.last.moved && !me.is_runnable() {
                return false;
            }
            let runnable = me.take_runnable() || self.last.moved;
            self.last = self.runner.pass(runnable, now);
            return true;
        };
        if self.next.is_some_and(|next| next <= now) {
            self.next = Some(timing.after(now));
            let busy = self.latched.swap(true, Ordering::Relaxed) || self.last.again;
            if busy {
                self.runner.overran(1);
            }
        }
        // genom3.md 7.4: a tick is taken when there is nothing left to continue.
        let tick = !self.last.again && self.latched.swap(false, Ordering::Relaxed);
        if !tick && !self.last.again {
            return false;
        }
        if tick {
            self.runner.cycle_begins(now);
            self.runner.cycle_ends(now);
            me.figures.lateness.record(0);
        }
        self.last = self.runner.pass(tick, now);
        true
    }
}
