//! The thread of a task: waits for ticks or wake-ups, and makes passes (genom3.md 7.4).

use std::sync::Arc;

use genom_description::model::Ix as _;

use super::rhythm::{Next, Rhythm};
use super::runner::Runner;
use crate::clock::{Clock, Turn};

/// Runs until asked to quit. The first pass, that of the start-up, is made at once.
pub(crate) fn run(mut runner: Runner) {
    let shared = Arc::clone(runner.shared());
    let task = runner.task();
    let me = &shared.tasks[task];
    // On a staged clock, each pass waits for its turn; `false` on others.
    let waits = |due: Option<u64>| match &shared.clock {
        Clock::Staged(stage) => {
            stage.wait(Turn::Pass { task: task.index(), due });
            true
        }
        Clock::Monotonic | Clock::Virtual(_) => false,
    };
    waits(Some(shared.clock.now()));
    let mut now = shared.clock.now();
    let mut rhythm = Rhythm::new(me, now);
    while !me.quits() {
        match rhythm.pass(&mut runner, me, now) {
            Next::Now(end) => {
                now = if waits(Some(end)) { shared.clock.now() } else { end };
                continue;
            }
            Next::At(date) => {
                if !waits(Some(date)) {
                    me.hurry.sleep_until(date);
                }
            }
            Next::Called => {
                while !waits(None) && !me.is_runnable() && !me.quits() {
                    std::thread::park();
                }
            }
        }
        now = shared.clock.now();
    }
    rhythm.ends(me, shared.clock.now());
}
