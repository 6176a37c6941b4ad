//! An instance that shares its thread with others: the control work that the thread does for it.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::clock::nanos;
use crate::control::Phase;
use crate::control::state_port::PERIOD_NS;
use crate::control::workers::LOOK;
use crate::engine::Engine;
use crate::executor::{Member, Turn};
use crate::running::RunningCodel;
use crate::task::timing::Timing;

impl Member for Engine {
    fn turn(self: Arc<Self>) -> Turn {
        self.attend();
        self.advance_shutdown();
        let now = self.shared.clock.now();
        let written = self.state_written.load(Ordering::Relaxed);
        if self.shared.plan.state_port().is_some() && self.seconds().after(written) <= now {
            self.write_state();
        }
        {
            let control = self.lock();
            if control.phase == Phase::Stopped {
                return Turn::Over;
            }
            if control.ready.is_empty() || control.contexts.is_empty() {
                let (often, late) = (self.looks_often(&control), self.next_late(&control));
                let next = self.next_look(often, now).into_iter().chain(late).min();
                return next.map_or(Turn::Idle, Turn::At);
            }
        }
        self.serve_next();
        Turn::More
    }

    fn left(&self) {
        self.thread_ended();
    }

    fn running(&self) -> Vec<RunningCodel> {
        let mut all = self.running_codels();
        for codel in &mut all {
            codel.owner = format!("{}/{}", self.name, codel.owner);
        }
        all
    }
}

impl Engine {
    /// When control has to look again although nobody rings: for the state port and for missed
    /// ticks every second, for activities that move more often.
    fn next_look(&self, often: bool, now: u64) -> Option<u64> {
        let seldom = self.watcher.is_some() || self.shared.plan.state_port().is_some();
        let seldom = seldom.then(|| self.seconds().after(now));
        often.then(|| now + nanos(LOOK)).into_iter().chain(seldom).min()
    }

    /// Whole seconds: the same dates for all members, so that one wake-up is enough for all.
    fn seconds(&self) -> Timing {
        let epoch = self.single.as_ref().map_or(0, |executor| executor.epoch());
        Timing::new(epoch, PERIOD_NS, 0)
    }
}
