//! Wakes a sending thread shortly before writers that keep a steady pace write again.
//!
//! To wake a sleeping thread takes tens of microseconds, which every sample would wait. Tasks are
//! periodic, so the thread knows when the next sample is due: it wakes before, and looks without
//! sleeping until the sample is there. That costs processor time, which has a limit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::thread;
use std::time::{Duration, Instant};

use crate::bell::Bell;

/// How long before a sample is due the thread wakes: timers may be late by as much.
const EARLY: Duration = Duration::from_micros(150);

/// How long after that it gives up: the writer may be late by as much.
const LATE: Duration = Duration::from_micros(150);

/// Gaps in a row that must be alike.
const STEADY: u32 = 3;

/// Writers faster than that are not waited for: the thread would hardly sleep.
const SHORTEST: Duration = Duration::from_micros(500);

/// Most time that may be saved up for looking.
const SAVINGS: Duration = Duration::from_millis(5);

/// When lines of samples go on.
#[derive(Debug)]
pub struct Forecast {
    /// Percent of the time that may be spent on looking.
    share: u32,
    lines: Vec<Rhythm>,
    /// Dates and lines, soonest first. A date counts only if its line still expects it.
    due: BinaryHeap<Reverse<(Instant, usize)>>,
    savings: Duration,
    /// Up to when time was saved.
    saved: Instant,
}

#[derive(Clone, Copy, Debug, Default)]
struct Rhythm {
    last: Option<Instant>,
    gap: Duration,
    /// Gaps in a row that were alike.
    alike: u32,
    due: Option<Instant>,
}

impl Rhythm {
    /// Notes a sample; when the next one is due.
    fn heard(&mut self, now: Instant) -> Option<Instant> {
        let gap = self.last.replace(now).map(|last| now.saturating_duration_since(last));
        let gap = gap.unwrap_or_default();
        if gap.abs_diff(self.gap) <= self.gap / 4 {
            self.alike = self.alike.saturating_add(1);
            self.gap = (self.gap * 7 + gap) / 8;
        } else {
            self.alike = 0;
            self.gap = gap;
        }
        let steady = self.alike >= STEADY && self.gap >= SHORTEST;
        self.due = steady.then(|| now + self.gap);
        self.due
    }
}

impl Forecast {
    /// A forecast that spends at most that many percent of one processor on looking; 0: it sleeps
    /// until it is woken, as it does where there is only one processor.
    #[must_use]
    pub fn new(percent: u8) -> Self {
        let alone = thread::available_parallelism().is_ok_and(|count| count.get() == 1);
        Self {
            share: if alone { 0 } else { percent.min(100).into() },
            lines: Vec::new(),
            due: BinaryHeap::new(),
            savings: SAVINGS,
            saved: Instant::now(),
        }
    }

    /// A sample of that line was there now.
    pub fn heard(&mut self, line: usize, now: Instant) {
        if self.share == 0 {
            return;
        }
        if self.lines.len() <= line {
            self.lines.resize_with(line + 1, Rhythm::default);
        }
        if let Some(due) = self.lines.get_mut(line).and_then(|rhythm| rhythm.heard(now)) {
            self.due.push(Reverse((due, line)));
        }
    }

    /// The line is another one from now on.
    pub fn forget(&mut self, line: usize) {
        if let Some(rhythm) = self.lines.get_mut(line) {
            *rhythm = Rhythm::default();
        }
    }

    /// Waits for a ring, at most `longest`; it may return without one before that. Always called
    /// by one same thread.
    pub fn wait(&mut self, bell: &Bell, longest: Duration) {
        let now = Instant::now();
        let sooner = self.next(now).filter(|due| *due < now + longest + EARLY);
        let Some(due) = sooner else {
            bell.wait(longest);
            return;
        };
        let sleep = due.saturating_duration_since(now + EARLY);
        if bell.wait(sleep) {
            return;
        }
        let start = Instant::now();
        bell.look(due + LATE);
        self.savings = self.savings.saturating_sub(start.elapsed());
    }

    /// When the next sample is due, if it may be waited for.
    fn next(&mut self, now: Instant) -> Option<Instant> {
        let saved = now.saturating_duration_since(self.saved) * self.share / 100;
        self.savings = (self.savings + saved).min(SAVINGS);
        self.saved = now;
        loop {
            let Reverse((due, line)) = *self.due.peek()?;
            let expected = self.lines.get(line).and_then(|rhythm| rhythm.due) == Some(due);
            if expected && now < due + LATE {
                return (self.savings >= EARLY + LATE).then_some(due);
            }
            self.due.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(1);

    fn steady(lines: usize, percent: u8) -> (Forecast, Instant) {
        let (mut forecast, start) = (Forecast::new(percent), Instant::now());
        // Also on a machine of one processor.
        forecast.share = percent.into();
        forecast.saved = start;
        for round in 0..6 {
            for line in 0..lines {
                forecast.heard(line, start + PERIOD * round + PERIOD / 10 * line as u32);
            }
        }
        (forecast, start + PERIOD * 5)
    }

    #[test]
    fn a_steady_writer_is_expected_once_and_a_silent_one_no_more() {
        let (mut forecast, last) = steady(1, 20);
        assert_eq!(forecast.next(last), Some(last + PERIOD));
        assert_eq!(forecast.next(last + PERIOD + LATE), None);
        assert!(forecast.due.is_empty());
    }

    #[test]
    fn a_writer_that_comes_early_is_expected_anew() {
        let (mut forecast, last) = steady(1, 20);
        let early = last + PERIOD * 9 / 10;
        forecast.heard(0, early);
        let due = forecast.next(early).unwrap();
        assert!(due > last + PERIOD, "the old date does not count");
        forecast.heard(0, early + PERIOD * 3);
        assert_eq!(forecast.next(early + PERIOD * 3), None, "out of step");
    }

    #[test]
    fn the_soonest_of_many_is_expected_first_and_a_line_forgotten_never() {
        let (mut forecast, last) = steady(3, 20);
        assert_eq!(forecast.next(last), Some(last + PERIOD));
        forecast.forget(0);
        assert_eq!(forecast.next(last), Some(last + PERIOD + PERIOD / 10));
    }

    #[test]
    fn looking_stops_when_its_share_is_used_up() {
        let (mut forecast, last) = steady(1, 20);
        forecast.savings = Duration::ZERO;
        forecast.saved = last;
        assert_eq!(forecast.next(last + PERIOD / 10), None);
        // A fifth of the time since then was saved.
        forecast.saved = last + PERIOD - (EARLY + LATE) * 5;
        assert_eq!(forecast.next(last + PERIOD), Some(last + PERIOD));
    }

    #[test]
    fn without_a_share_nothing_is_expected() {
        let (mut forecast, last) = steady(1, 0);
        assert_eq!(forecast.next(last), None);
        assert!(forecast.lines.is_empty());
    }

    #[test]
    fn fast_and_unsteady_writers_are_not_waited_for() {
        let (mut forecast, _) = steady(0, 20);
        let mut now = Instant::now();
        for gap in [100, 100, 100, 100, 100, 100] {
            now += Duration::from_micros(gap);
            forecast.heard(0, now);
        }
        assert_eq!(forecast.next(now), None);
        for gap in [1000, 3000, 1000, 3000, 1000, 3000] {
            now += Duration::from_micros(gap);
            forecast.heard(1, now);
        }
        assert_eq!(forecast.next(now), None);
    }
}
