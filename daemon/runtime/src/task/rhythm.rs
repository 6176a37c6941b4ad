//! When a task in real time makes its next pass (genom3.md 7.4), and what is counted about it.
//!
//! Its driver, a thread of the task or one that many tasks share, makes the passes and waits
//! between them.

use super::core::Passed;
use super::runner::Runner;
use super::timing::{RESPONSE, Timing};
use crate::shared::TaskShared;

/// When the next pass is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// At once; the last one ended at this date.
    Now(u64),
    /// At the tick of this date, or earlier if somebody hurries the task.
    At(u64),
    /// When something happens in the component.
    Called,
}

/// The passes of one task.
#[derive(Debug)]
pub(crate) enum Rhythm {
    /// A cycle begins at each tick.
    Periodic {
        /// Dates of ticks.
        timing: Timing,
        /// Date of the next tick.
        next: u64,
        /// The next pass begins a cycle; otherwise it continues one.
        tick: bool,
        /// The task waits for the tick at `next`.
        waits: bool,
    },
    /// A cycle begins whenever something happened.
    Aperiodic {
        /// Result of the last pass: whether codels have to continue, and pauses end.
        last: Passed,
        /// A cycle is under way.
        at_work: bool,
    },
}

impl Rhythm {
    /// Of a task that makes its first pass, that of the start-up, at once.
    pub(crate) fn new(me: &TaskShared, now: u64) -> Self {
        let Some(timing) = me.timing else {
            return Self::Aperiodic { last: Passed::default(), at_work: false };
        };
        let next = timing.after(now);
        me.figures.overruns.begins(timing, next);
        Self::Periodic { timing, next, tick: true, waits: false }
    }

    /// One pass at date `now`.
    #[inline]
    pub(crate) fn pass(&mut self, runner: &mut Runner, me: &TaskShared, now: u64) -> Next {
        match self {
            Self::Periodic { timing, next, tick, waits } => {
                if std::mem::take(waits) {
                    // Ticks that passed while the task slept too long are missed.
                    *next = serve(*timing, *next, now, 0, runner, me);
                }
                if *tick {
                    runner.cycle_begins(now);
                }
                let again = runner.pass(*tick, now).again;
                *tick = !again;
                let end = runner.end();
                if again {
                    return Next::Now(end);
                }
                runner.cycle_ends(end);
                if end >= *next {
                    // The tick is latched: one pass at once, missed ticks are not caught up with.
                    *next = serve(*timing, *next, end, 1, runner, me);
                    return Next::Now(end);
                }
                me.figures.overruns.sleeps();
                *waits = true;
                Next::At(*next)
            }
            Self::Aperiodic { last, at_work } => {
                if !std::mem::replace(at_work, true) {
                    runner.cycle_begins(now);
                }
                let runnable = me.take_runnable() || last.moved;
                *last = runner.pass(runnable, now);
                let end = runner.end();
                if last.again || last.moved || me.is_runnable() {
                    return Next::Now(end);
                }
                *at_work = false;
                runner.cycle_ends(end);
                Next::Called
            }
        }
    }

    /// The date by which a pass that is due now should be made: the next tick, since the one after
    /// is missed otherwise. It advances with the clock, so that a task that never pauses does not
    /// precede others for ever.
    pub(crate) fn deadline(&self, now: u64) -> u64 {
        match self {
            Self::Periodic { next, .. } if *next > now => *next,
            Self::Periodic { timing, .. } => timing.after(now),
            Self::Aperiodic { .. } => now + RESPONSE,
        }
    }

    /// The task ends at this date.
    pub(crate) fn ends(&self, me: &TaskShared, now: u64) {
        let at_work = match self {
            Self::Periodic { tick, .. } => !tick,
            Self::Aperiodic { at_work, .. } => *at_work,
        };
        if at_work {
            me.figures.cycles.ends(now);
        }
        if let Self::Periodic { timing, .. } = self {
            me.figures.overruns.ends(*timing, now);
        }
    }
}

/// Serves the tick at `next` at date `now`, with `missed` ticks besides those that passed since;
/// returns the date of the following one.
fn serve(
    timing: Timing,
    next: u64,
    now: u64,
    missed: u64,
    runner: &mut Runner,
    me: &TaskShared,
) -> u64 {
    let missed = missed + timing.since(next, now);
    if missed > 0 {
        runner.overran(missed);
    }
    me.figures.lateness.record(now.saturating_sub(next));
    timing.after(now.max(next))
}
