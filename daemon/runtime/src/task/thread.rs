//! The thread of a task: waits for ticks or wake-ups, and makes passes (genom3.md 7.4).

use super::core::Passed;
use super::runner::Runner;
use super::timing::Timing;

/// Runs until asked to quit. The first pass, that of the start-up, is made at once.
pub(crate) fn run(mut runner: Runner) {
    match runner.shared().tasks[runner.task()].timing {
        Some(timing) => periodic(&mut runner, timing),
        None => aperiodic(&mut runner),
    }
}

fn aperiodic(runner: &mut Runner) {
    let shared = std::sync::Arc::clone(runner.shared());
    let me = &shared.tasks[runner.task()];
    // Result of the last pass: whether codels have to continue, and pauses end.
    let mut last = Passed::default();
    let cycles = &me.figures.cycles;
    let mut now = shared.clock.now();
    cycles.begins(now);
    while !me.quits() {
        if !last.again && !last.moved && !me.is_runnable() {
            cycles.ends(now);
            while !me.is_runnable() && !me.quits() {
                std::thread::park();
            }
            if me.quits() {
                return;
            }
            now = shared.clock.now();
            cycles.begins(now);
        }
        let runnable = me.take_runnable() || last.moved;
        last = runner.pass(runnable, now);
        now = runner.end();
    }
    cycles.ends(now);
}

fn periodic(runner: &mut Runner, timing: Timing) {
    let shared = std::sync::Arc::clone(runner.shared());
    let me = &shared.tasks[runner.task()];
    let mut began = shared.clock.now();
    let mut next = timing.after(began);
    let pace = &me.figures.overruns;
    pace.begins(timing, next);
    let cycles = &me.figures.cycles;
    let mut tick = true;
    let mut now = began;
    while !me.quits() {
        if tick {
            cycles.begins(began);
        }
        if runner.pass(tick, now).again {
            tick = false;
            now = runner.end();
            continue;
        }
        tick = true;
        let end = runner.end();
        cycles.ends(end);
        let at_work = end >= next;
        if at_work {
            // The tick is latched: one pass at once, missed ticks are not caught up with.
            began = end;
        } else {
            pace.sleeps();
            me.hurry.sleep_until(next);
            began = shared.clock.now();
        }
        // Ticks that passed while the task slept too long are missed as well.
        let missed = u64::from(at_work) + timing.since(next, began);
        if missed > 0 {
            runner.overran(missed);
        }
        now = began;
        me.figures.lateness.record(began.saturating_sub(next));
        next = timing.after(began.max(next));
    }
    if !tick {
        cycles.ends(now);
    }
    pace.ends(timing, shared.clock.now());
}
