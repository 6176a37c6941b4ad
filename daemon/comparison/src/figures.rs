//! Median and 99th percentile of durations.

use serde::{Deserialize, Serialize};

/// Percentiles of a set of durations, in microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Figures {
    /// Half of the durations are at most this long.
    pub p50: f64,
    /// So are 99 of 100.
    pub p99: f64,
}

impl Figures {
    /// Of durations in nanoseconds, in any order; `None` if there are none.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
    pub fn of(mut durations: Vec<u64>) -> Option<Self> {
        durations.sort_unstable();
        let last = durations.len().checked_sub(1)?;
        let at = |hundredths: usize| {
            durations.get(last * hundredths / 100).map(|duration| *duration as f64 / 1000.0)
        };
        Some(Self { p50: at(50)?, p99: at(99)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_and_ninety_nine_hundredths_are_at_most_the_percentiles() {
        let figures = Figures::of((1..=101).rev().map(|n| n * 1000).collect()).unwrap();
        assert_eq!(figures, Figures { p50: 51.0, p99: 100.0 });
        assert_eq!(Figures::of(vec![500]), Some(Figures { p50: 0.5, p99: 0.5 }));
        assert_eq!(Figures::of(Vec::new()), None);
    }
}
