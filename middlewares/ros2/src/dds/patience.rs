//! How long is waited for acknowledgements when something closes. A reader that is gone without a word
//! (its process was killed, or its farewell was lost) acknowledges nothing until its lease is over: what
//! closes meanwhile would wait the longest time each, and hundreds of ends one after the other.

use std::time::{Duration, Instant};

/// The longest wait.
const LONGEST: Duration = Duration::from_millis(100);

/// The shortest one: a reader of the same machine that is there takes less.
const SHORTEST: Duration = Duration::from_millis(5);

/// How much is waited in vain, before waits are the shortest ones.
const FULL: Duration = Duration::from_millis(500);

/// What comes back of that, as a part of the time that passes.
const BACK: u32 = 20;

/// What is left to wait in vain.
#[derive(Debug)]
pub(crate) struct Patience {
    left: Duration,
    since: Instant,
}

impl Patience {
    pub(crate) fn new() -> Self {
        Self { left: FULL, since: Instant::now() }
    }

    /// Waits by `wait`, for so long at most; it tells whether all was acknowledged.
    pub(crate) fn wait(&mut self, wait: impl FnOnce(Duration) -> bool) {
        let begin = Instant::now();
        let longest = self.at(begin);
        if !wait(longest) {
            self.in_vain(begin.elapsed());
        }
    }

    fn at(&mut self, now: Instant) -> Duration {
        let back = now.saturating_duration_since(self.since) / BACK;
        (self.left, self.since) = ((self.left + back).min(FULL), now);
        self.left.clamp(SHORTEST, LONGEST)
    }

    fn in_vain(&mut self, waited: Duration) {
        self.left = self.left.saturating_sub(waited);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hundreds_of_waits_in_vain_take_little_more_than_the_first_few() {
        let mut patience = Patience::new();
        let (mut now, mut all) = (Instant::now(), Duration::ZERO);
        for _ in 0..1000 {
            let longest = patience.at(now);
            patience.in_vain(longest);
            now += longest;
            all += longest;
        }
        assert!(all < FULL + 1000 * 2 * SHORTEST, "{all:?}");
    }

    #[test]
    fn after_a_while_waits_are_long_again() {
        let mut patience = Patience::new();
        let now = Instant::now();
        patience.in_vain(FULL);
        assert_eq!(patience.at(now), SHORTEST);
        assert_eq!(patience.at(now + BACK * LONGEST), LONGEST);
    }

    #[test]
    fn what_is_acknowledged_takes_nothing_of_it() {
        let mut patience = Patience::new();
        for _ in 0..100 {
            patience.wait(|_| true);
        }
        assert_eq!(patience.at(Instant::now()), LONGEST);
        assert_eq!(patience.left, FULL);
    }
}
