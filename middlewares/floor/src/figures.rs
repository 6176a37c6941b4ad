//! Median and 99th percentile of durations.

use std::fmt;

/// Percentiles of a set of durations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Median in nanoseconds.
    pub p50: f64,
    /// 99th percentile in nanoseconds.
    pub p99: f64,
}

impl Figures {
    /// Computes the percentiles of durations given in nanoseconds; `None` if there are none.
    #[must_use]
    pub fn of(mut durations: Vec<f64>) -> Option<Self> {
        durations.sort_by(f64::total_cmp);
        let last = durations.len().checked_sub(1)?;
        let at = |hundredth: usize| durations.get(last * hundredth / 100).copied();
        Some(Self { p50: at(50)?, p99: at(99)? })
    }
}

impl fmt::Display for Figures {
    /// In microseconds: `p50 / p99`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{:.2} / {:.2}", self.p50 / 1000.0, self.p99 / 1000.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_and_the_end_are_found_in_any_order() {
        let figures = Figures::of((1..=101).rev().map(f64::from).collect()).unwrap();
        assert_eq!((figures.p50, figures.p99), (51.0, 100.0));
        assert_eq!(Figures::of(vec![2500.0]).unwrap().to_string(), "2.50 / 2.50");
        assert_eq!(Figures::of(Vec::new()), None);
    }
}
