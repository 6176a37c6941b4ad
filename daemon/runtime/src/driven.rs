//! The tasks of an instance on a virtual clock, run by whoever steps it.

use std::sync::atomic::Ordering;

use crate::clock::Driven;
use crate::control::Phase;
use crate::engine::{Engine, lock};

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
