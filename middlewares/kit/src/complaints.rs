//! Counts unusable messages of others, and limits the log to one line per second.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Minimum time between two lines.
pub const BETWEEN_LINES: Duration = Duration::from_secs(1);

/// Counts errors of one kind.
#[derive(Debug, Default)]
pub struct Complaints(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    count: u64,
    line: Option<Instant>,
}

impl Complaints {
    /// None so far.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(State { count: 0, line: None }))
    }

    /// Counts one error. Returns the count so far if a line is due.
    pub fn add(&self) -> Option<u64> {
        self.add_at(Instant::now())
    }

    fn add_at(&self, now: Instant) -> Option<u64> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.count += 1;
        let due =
            state.line.is_none_or(|line| now.saturating_duration_since(line) >= BETWEEN_LINES);
        due.then(|| {
            state.line = Some(now);
            state.count
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_counted_and_told_once_in_a_while() {
        let (complaints, start) = (Complaints::default(), Instant::now());
        let told: Vec<u64> =
            (0..2500).filter_map(|n| complaints.add_at(start + Duration::from_millis(n))).collect();
        assert_eq!(told, [1, 1001, 2001]);
    }
}
