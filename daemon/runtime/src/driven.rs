//! The tasks of an instance on a virtual clock, run by whoever steps it.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Driven;
use crate::control::Phase;
use crate::engine::{Engine, lock};
use crate::task::core::Passed;
use crate::task::runner::Runner;

/// A task without thread.
pub(crate) struct DrivenTask {
    runner: Runner,
    /// What the last pass left.
    last: Passed,
    /// Date of the next tick, for a periodic task.
    next: Option<u64>,
    /// A tick that came while the task was still at work, or that a shutdown asks for.
    latched: AtomicBool,
}

impl DrivenTask {
    pub(crate) fn new(runner: Runner) -> Self {
        let now = runner.shared().clock.now();
        let next = runner.shared().tasks[runner.task()].timing.map(|timing| timing.after(now));
        Self { runner, last: Passed::default(), next, latched: AtomicBool::new(false) }
    }

    /// The pass of the start-up.
    pub(crate) fn start(&mut self, now: u64) {
        let shared = self.runner.shared();
        shared.tasks[self.runner.task()].take_runnable();
        self.last = self.runner.pass(true, now);
    }

    /// One pass, if one is due; whether it was.
    fn run(&mut self, now: u64) -> bool {
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
        // 7.4: a tick is looked at when there is nothing to continue.
        let tick = !self.last.again && self.latched.swap(false, Ordering::Relaxed);
        if !tick && !self.last.again {
            return false;
        }
        if tick {
            me.figures.cycles.record(0);
            me.figures.lateness.record(0);
        }
        self.last = self.runner.pass(tick, now);
        true
    }
}

impl Driven for Engine {
    fn next_date(&self) -> Option<u64> {
        if self.lock().phase == Phase::Stopped {
            return None;
        }
        let tasks = lock(self.driven.as_ref()?);
        // The state port is due as well.
        tasks.iter().filter_map(|task| task.next).chain([self.state_due()]).min()
    }

    fn run(&self, now: u64) -> bool {
        let Some(driven) = &self.driven else { return false };
        if self.lock().phase == Phase::Stopped {
            return false;
        }
        let mut busy = false;
        {
            let mut tasks = lock(driven);
            for task in tasks.iter_mut() {
                busy |= task.run(now);
            }
        }
        busy |= self.attend();
        self.refresh_state();
        busy
    }
}

impl Engine {
    /// Runs all tasks as if they ticked, until `done`; `false` when they do not get there.
    pub(crate) fn drive_until(&self, done: impl Fn(&Self) -> bool) -> bool {
        /// Ticks of the slowest shutdown.
        const MOST: usize = 100_000;
        for _ in 0..MOST {
            if done(self) {
                return true;
            }
            if let Some(driven) = &self.driven {
                lock(driven).iter().for_each(|task| task.latched.store(true, Ordering::Relaxed));
            }
            self.run(self.shared.clock.now());
        }
        done(self)
    }
}
