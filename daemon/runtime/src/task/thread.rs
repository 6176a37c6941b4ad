//! The thread of a task: waits for ticks or wake-ups, and makes passes (genom3.md 7.4).

use std::sync::Arc;

use super::rhythm::{Next, Rhythm};
use super::runner::Runner;

/// Runs until asked to quit. The first pass, that of the start-up, is made at once.
pub(crate) fn run(mut runner: Runner) {
    let shared = Arc::clone(runner.shared());
    let me = &shared.tasks[runner.task()];
    let mut now = shared.clock.now();
    let mut rhythm = Rhythm::new(me, now);
    while !me.quits() {
        match rhythm.pass(&mut runner, me, now) {
            Next::Now(end) => {
                now = end;
                continue;
            }
            Next::At(date) => {
                me.hurry.sleep_until(date);
            }
            Next::Called => {
                while !me.is_runnable() && !me.quits() {
                    std::thread::park();
                }
            }
        }
        now = shared.clock.now();
    }
    rhythm.ends(me, shared.clock.now());
}
