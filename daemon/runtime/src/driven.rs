//! The tasks of an instance on a virtual clock, run by the thread that steps the clock.

use std::sync::atomic::Ordering;
use std::sync::{Mutex, TryLockError};
use std::time::{Duration, Instant};

use crate::clock::Driven;
use crate::control::{Phase, Stage};
use crate::engine::Engine;
use crate::lock::{Guard, lock};
use crate::task::driven::DrivenTask;

impl Driven for Engine {
    fn next_date(&self) -> Option<u64> {
        let late = {
            let control = self.lock();
            if control.phase == Phase::Stopped {
                return None;
            }
            self.next_late(&control)
        };
        let tasks = lock(self.driven.as_ref()?);
        // The state port is due as well.
        tasks.iter().filter_map(|task| task.next).chain([self.state_due()]).chain(late).min()
    }

    fn run(&self, now: u64) -> bool {
        let Some(driven) = &self.driven else { return false };
        self.run_tasks(lock(driven), now)
    }

    fn take_in_accepted(&self) {
        let mut control = self.lock();
        while control.entries.iter().any(|entry| matches!(entry.stage, Stage::Accepting)) {
            control = self.quiet.wait(control);
        }
    }
}

impl Engine {
    fn run_tasks(&self, mut tasks: Guard<'_, Vec<DrivenTask>>, now: u64) -> bool {
        if self.lock().phase == Phase::Stopped {
            return false;
        }
        let mut busy = false;
        for task in tasks.iter_mut() {
            busy |= task.run(now);
        }
        drop(tasks);
        busy |= self.attend();
        self.refresh_state();
        busy
    }

    /// Runs all tasks as if they had ticks, until `done`; `false` when that does not happen, or
    /// when the thread that steps the clock is in a codel that does not return.
    pub(crate) fn drive_until(&self, deadline: Instant, done: impl Fn(&Self) -> bool) -> bool {
        /// Most ticks that a shutdown may take.
        const MOST: usize = 100_000;
        let Some(driven) = &self.driven else { return false };
        for _ in 0..MOST {
            if done(self) {
                return true;
            }
            let Some(tasks) = lock_until(driven, deadline) else { return false };
            tasks.iter().for_each(|task| task.latched.store(true, Ordering::Relaxed));
            self.run_tasks(tasks, self.shared.clock.now());
        }
        done(self)
    }
}

/// Locks the mutex; `None` when the deadline passes first.
fn lock_until<T>(mutex: &Mutex<T>, deadline: Instant) -> Option<Guard<'_, T>> {
    /// Pause between two attempts; the lock is held for long only if a codel does not return.
    const LOOK: Duration = Duration::from_millis(1);
    loop {
        match mutex.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(poisoned)) => return Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) if Instant::now() >= deadline => return None,
            Err(TryLockError::WouldBlock) => std::thread::park_timeout(LOOK),
        }
    }
}
