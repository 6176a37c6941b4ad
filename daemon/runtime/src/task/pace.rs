//! Ticks that a task missed. Any thread may read them, also while a codel of the task does not
//! return.
//!
//! The task counts the ticks that it served and, after waking up late, those that it missed. While
//! it is stuck, a reader computes the rest from the clock: `missed = due - served`.

use std::sync::atomic::{AtomicU64, Ordering};

use super::timing::Timing;

/// Means that there are no ticks to serve.
const NONE: u64 = u64::MAX;

/// Ticks served and missed; only the task writes.
#[derive(Debug)]
pub(crate) struct Pace {
    /// Ticks served since the epoch. The tick that the task sleeps for counts as served: it is
    /// missed only when the next one comes.
    served: AtomicU64,
    missed: AtomicU64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { served: AtomicU64::new(NONE), missed: AtomicU64::new(0) }
    }
}

impl Pace {
    /// The first tick to serve is at `next`.
    pub(crate) fn begins(&self, timing: Timing, next: u64) {
        self.served.store(timing.count(next).saturating_sub(1), Ordering::Release);
    }

    /// The task sleeps until the next tick.
    #[inline]
    pub(crate) fn sleeps(&self) {
        self.served.store(self.served.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }

    /// Records ticks missed while it was at work, or slept too long.
    #[inline]
    pub(crate) fn missed(&self, ticks: u64) {
        // Stored with release after `served`: a reader that sees this value also sees the ticks
        // served before it, so the total never decreases.
        self.missed.store(self.missed.load(Ordering::Relaxed) + ticks, Ordering::Release);
    }

    /// The task ends at this date: no more ticks are missed.
    pub(crate) fn ends(&self, timing: Timing, now: u64) {
        let missed = self.read(Some(timing), now);
        self.missed.store(missed, Ordering::Release);
        self.served.store(NONE, Ordering::Release);
    }

    /// Ticks missed until now.
    pub(crate) fn read(&self, timing: Option<Timing>, now: u64) -> u64 {
        let missed = self.missed.load(Ordering::Acquire);
        let served = self.served.load(Ordering::Acquire);
        timing.map_or(missed, |timing| missed.max(timing.count(now).saturating_sub(served)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_missed_from_the_moment_they_come_and_counted_once() {
        // Ticks at 100, 110, 120...
        let (timing, pace) = (Timing::new(100, 10, 0), Pace::default());
        let read = |now| pace.read(Some(timing), now);
        assert_eq!(read(500), 0);
        pace.begins(timing, timing.after(105));
        assert_eq!([105, 109, 110, 119, 120].map(read), [0, 0, 1, 1, 2]);
        // At work until 133: the ticks at 110, 120 and 130 are missed.
        pace.missed(1 + timing.since(110, 133));
        assert_eq!([133, 139, 140].map(read), [3, 3, 4]);
        // Done at 135; sleeps until 140 and wakes at 141: none is missed.
        pace.sleeps();
        assert_eq!([135, 140, 149, 150].map(read), [3, 3, 3, 4]);
        // Sleeps until 150 but wakes at 175: those at 160 and 170 are missed.
        pace.sleeps();
        assert_eq!([149, 159, 160, 175].map(read), [3, 3, 4, 5]);
        pace.missed(timing.since(150, 175));
        assert_eq!([175, 179, 180].map(read), [5, 5, 6]);
        // Ends at 185, after one more tick.
        pace.ends(timing, 185);
        assert_eq!([185, 9999].map(read), [6, 6]);
    }

    #[test]
    fn ticks_before_the_first_date_are_none() {
        let (timing, pace) = (Timing::new(100, 10, 5), Pace::default());
        pace.begins(timing, timing.after(0));
        let read = |now| pace.read(Some(timing), now);
        assert_eq!([0, 104, 105, 115].map(read), [0, 0, 1, 2]);
    }
}
