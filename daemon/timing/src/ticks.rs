//! Ticks of tasks with periods.

/// Dates of ticks that are looked at.
const TICKS: u64 = 4_096;

/// Ticks of a task: at `delay + n * period` from the start of the component, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Period {
    /// Time between two ticks.
    pub period: u64,
    /// Date of the first tick, less than the period; the one at 0 is that of the start-up.
    pub delay: u64,
}

impl Period {
    /// The date of its first tick after the start-up, which begins at 0.
    #[must_use]
    pub fn first(self) -> u64 {
        if self.delay > 0 { self.delay } else { self.period }
    }

    /// How long before the start of the component its last tick would have been; 0 if that is at the start.
    #[must_use]
    pub fn before_start(self) -> u64 {
        (self.period - self.delay) % self.period
    }
}

/// Cycles of another task that there may be in part while one of this length lasts from a tick on:
/// all dates of ticks are known. A cycle of the other task is over after `response` at the latest.
#[must_use]
pub fn cycles(own: Period, length: u64, (other, response): (Period, u64)) -> u64 {
    let period = other.period;
    let ticks = common(own.period, period).map(|common| common / own.period);
    let Some(ticks) = ticks.filter(|ticks| *ticks <= TICKS) else {
        return (length.saturating_add(response) / period).saturating_add(1);
    };
    let count = |tick: u64| {
        // Later by a period of the other, so that nothing is below zero.
        let begin = own.delay + tick * own.period + period;
        // Ticks before the end whose cycles may end after the beginning.
        let before = |date: u64| {
            let first = other.delay;
            if date <= first { 0 } else { (date - first).div_ceil(period) }
        };
        let ends = begin.saturating_sub(response).saturating_add(1);
        before(begin + length).saturating_sub(before(ends))
    };
    (0..ticks).map(count).max().unwrap_or(0)
}

/// The least common multiple: from one date at which both tick to the next, without delays.
#[must_use]
pub fn common(a: u64, b: u64) -> Option<u64> {
    (a / gcd(a, b).max(1)).checked_mul(b)
}

/// The greatest number of which both are multiples.
#[must_use]
pub fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_counted_at_the_dates_of_their_ticks() {
        let own = Period { period: 10, delay: 0 };
        let other = |period: u64, delay: u64, response: u64| (Period { period, delay }, response);
        // Both at zero: the one of 40 is over when the next of 10 begins, or is not.
        assert_eq!(cycles(own, 5, other(40, 0, 10)), 1);
        assert_eq!(cycles(own, 5, other(40, 0, 35)), 1);
        // Two ticks of 5 are in a cycle of 6, one in a cycle of 5.
        assert_eq!(cycles(own, 6, other(5, 0, 2)), 2);
        assert_eq!(cycles(own, 5, other(5, 0, 2)), 1);
        // With another delay, an earlier one may go on.
        assert_eq!(cycles(own, 2, other(10, 5, 5)), 0);
        assert_eq!(cycles(own, 2, other(10, 5, 6)), 1);
        // All pairs of dates, one by one.
        for (period, delay, response, length) in
            [(7, 3, 4, 9), (3, 1, 2, 8), (15, 14, 6, 3), (10, 9, 9, 4), (4, 0, 3, 9)]
        {
            let count = |tick: u64| {
                let (begin, end) = (tick * 10, tick * 10 + length);
                let ticks = (0..2_000).map(|n| delay + n * period);
                ticks.filter(|t| *t < end && t + response > begin).count()
            };
            let most = (0..200).map(count).max().unwrap() as u64;
            assert_eq!(cycles(own, length, other(period, delay, response)), most);
        }
    }
}
