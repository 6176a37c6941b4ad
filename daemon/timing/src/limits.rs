//! Limits of an exploration.

use std::fmt;
use std::time::{Duration, Instant};

/// Limits of an exploration.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Number of states.
    pub states: usize,
    /// Memory, in bytes.
    pub memory: usize,
    /// Time.
    pub time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { states: 5_000_000, memory: 1 << 30, time: Duration::from_secs(10) }
    }
}

/// The limit that ended an exploration before all states were seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// [`Limits::states`].
    States(usize),
    /// [`Limits::memory`].
    Memory(usize),
    /// [`Limits::time`].
    Time(Duration),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::States(states) => write!(f, "more than {states} states"),
            Self::Memory(bytes) => write!(f, "more than {} MiB of states", bytes >> 20),
            // What several share is rarely a round number.
            Self::Time(time) => {
                write!(f, "more than {} s", (time.as_secs_f64() * 1e3).round() / 1e3)
            }
        }
    }
}

impl Limits {
    /// Limits of a first look, in which what is small is seen as a whole: a part of the time, and a
    /// second and a half if that is allowed.
    #[must_use]
    pub fn first(&self) -> Self {
        const PART: u32 = 40;
        let time = (self.time / PART).max(Duration::from_millis(1500)).min(self.time);
        Self { states: self.states.min(500_000), time, ..*self }
    }

    /// The same with what is left of the time since `begin`, shared with so many others.
    #[must_use]
    pub fn share(&self, begin: Instant, others: usize) -> Self {
        let sharing = u32::try_from(others.saturating_add(1)).unwrap_or(u32::MAX);
        Self { time: self.time.saturating_sub(begin.elapsed()) / sharing, ..*self }
    }

    /// The limit that is passed, if one is: the time is looked at now and then.
    #[must_use]
    pub fn passed(&self, states: usize, bytes: usize, at: usize, begin: Instant) -> Option<Limit> {
        /// States between two looks at the clock.
        const LOOK: usize = 256;
        if states > self.states {
            return Some(Limit::States(self.states));
        }
        if bytes > self.memory {
            return Some(Limit::Memory(self.memory));
        }
        let late = at.is_multiple_of(LOOK) && begin.elapsed() > self.time;
        late.then_some(Limit::Time(self.time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_of_time_is_told_in_milliseconds_at_most() {
        let told = |micros| Limit::Time(Duration::from_micros(micros)).to_string();
        assert_eq!(told(1_499_969), "more than 1.5 s");
        assert_eq!([told(10_000_000), told(50_000)], ["more than 10 s", "more than 0.05 s"]);
    }
}
