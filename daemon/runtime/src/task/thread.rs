//! The thread of a task: waits for ticks or for being woken, and passes (genom3.md 7.4).

use std::time::Duration;

use super::runner::Runner;
use super::timing::Timing;
use crate::clock::sleep_until;

/// Sleeps longer than this can be cut short by a shutdown.
const LONG: u64 = 100_000_000;

/// Runs until told to quit. The first pass is made at once: it is the start-up's.
pub(crate) fn run(mut runner: Runner) {
    match runner.shared().tasks[runner.task()].timing {
        Some(timing) => periodic(&mut runner, timing),
        None => aperiodic(&mut runner),
    }
}

fn aperiodic(runner: &mut Runner) {
    let shared = std::sync::Arc::clone(runner.shared());
    let me = &shared.tasks[runner.task()];
    let mut again = false;
    let mut began = shared.clock.now();
    while !me.quits() {
        if !again && !me.is_runnable() {
            me.figures.cycles.record(shared.clock.now().saturating_sub(began));
            while !me.is_runnable() && !me.quits() {
                std::thread::park();
            }
            began = shared.clock.now();
        }
        let runnable = me.take_runnable();
        again = runner.pass(runnable, shared.clock.now()).again;
    }
}

fn periodic(runner: &mut Runner, timing: Timing) {
    let shared = std::sync::Arc::clone(runner.shared());
    let me = &shared.tasks[runner.task()];
    let mut began = shared.clock.now();
    let mut next = timing.after(began);
    let mut tick = true;
    loop {
        let now = shared.clock.now();
        if me.quits() {
            break;
        }
        if runner.pass(tick, now).again {
            tick = false;
            continue;
        }
        tick = true;
        let end = shared.clock.now();
        me.figures.cycles.record(end.saturating_sub(began));
        if end >= next {
            // The tick is latched: one pass at once, no burst of those that were missed.
            runner.overran(1 + (end - next) / timing.period);
            began = end;
        } else {
            wait(me, next, end);
            began = shared.clock.now();
        }
        me.figures.lateness.record(began.saturating_sub(next));
        next = timing.after(began.max(next));
    }
}

/// Sleeps until a tick; long sleeps end early when the instance shuts down.
fn wait(me: &crate::shared::TaskShared, date: u64, mut now: u64) {
    while date - now > LONG {
        if me.take_hurry() {
            return;
        }
        std::thread::park_timeout(Duration::from_nanos(date - now - LONG / 2));
        now = crate::clock::Clock::Monotonic.now().min(date);
    }
    sleep_until(date);
}
