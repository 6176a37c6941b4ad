//! What is kept of a number's samples: the least and the greatest of each short time, so that no
//! peak is missed however many samples there are.

use std::collections::VecDeque;

/// Times that a plot is divided into: more than a terminal has columns of dots.
pub(crate) const TIMES: usize = 2048;

/// The samples of one number.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    /// Length of a time, in nanoseconds.
    step: u64,
    /// By number of the time, the latest last; times without a sample are left out.
    all: VecDeque<(u64, Range)>,
    /// Samples so far.
    pub(crate) count: u64,
    pub(crate) last: Option<f64>,
}

/// Least and greatest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) least: f64,
    pub(crate) most: f64,
}

impl Range {
    fn add(&mut self, other: Self) {
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
    }
}

impl Columns {
    /// For a plot of `span` nanoseconds.
    pub(crate) fn new(span: u64) -> Self {
        let step = (span / TIMES as u64).max(1);
        Self { step, all: VecDeque::new(), count: 0, last: None }
    }

    /// Adds a sample. Values that are no numbers are counted only.
    pub(crate) fn add(&mut self, date: u64, value: f64) {
        self.count += 1;
        self.last = Some(value);
        if !value.is_finite() {
            return;
        }
        let (time, range) = (date / self.step, Range { least: value, most: value });
        match self.all.back_mut() {
            Some((last, here)) if *last >= time => here.add(range),
            _ => self.all.push_back((time, range)),
        }
        while self.all.front().is_some_and(|(first, _)| first + TIMES as u64 <= time) {
            self.all.pop_front();
        }
    }

    /// The ranges of `count` columns of the time up to `end`, oldest first: number of the column, from
    /// 0, and the range of all samples in it.
    pub(crate) fn fit(&self, end: u64, count: usize) -> Vec<(usize, Range)> {
        let first = (end / self.step + 1).saturating_sub(TIMES as u64);
        let mut fitted: Vec<(usize, Range)> = Vec::new();
        for (time, range) in self.all.iter().filter(|(time, _)| *time >= first) {
            #[allow(clippy::cast_possible_truncation, reason = "less than TIMES")]
            let column = (((*time - first) as usize) * count / TIMES).min(count.saturating_sub(1));
            match fitted.last_mut() {
                Some((last, here)) if *last == column => here.add(*range),
                _ => fitted.push((column, *range)),
            }
        }
        fitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A peak of one sample among a hundred thousand is there, at every width.
    #[test]
    fn no_peak_is_missed() {
        let span = 10_000_000_000_u64;
        let mut columns = Columns::new(span);
        for number in 0..100_000_u64 {
            let value = if number == 43_210 { 7.0 } else { (number % 3) as f64 };
            columns.add(number * 100_000, value);
        }
        let end = 99_999 * 100_000;
        for count in [1, 10, 160, 1000] {
            let fitted = columns.fit(end, count);
            assert_eq!(fitted.len(), count);
            let peaks: Vec<_> = fitted.iter().filter(|(_, range)| range.most == 7.0).collect();
            assert_eq!(peaks.len(), 1, "{count}");
            assert!(peaks[0].0.abs_diff(43_210 * count / 100_000) <= 1, "{count}");
            assert!(fitted.iter().all(|(_, range)| range.least == 0.0));
        }
    }

    #[test]
    fn what_is_older_than_the_plot_is_forgotten_and_what_is_no_number_only_counted() {
        let mut columns = Columns::new(2_048_000);
        columns.add(0, 100.0);
        for number in 0..10_000 {
            columns.add(number * 1000, 1.0);
        }
        columns.add(10_000_000, f64::NAN);
        assert!(columns.all.len() <= TIMES);
        let fitted = columns.fit(9_999_000, 4);
        assert!(fitted.iter().all(|(_, range)| range.most == 1.0), "{fitted:?}");
        assert_eq!(columns.count, 10_002);
        assert!(columns.last.is_some_and(f64::is_nan));
    }

    #[test]
    fn gaps_stay_gaps() {
        let mut columns = Columns::new(2_048_000);
        columns.add(0, 1.0);
        columns.add(2_000_000, 2.0);
        let places: Vec<_> = columns.fit(2_047_000, 4).iter().map(|(place, _)| *place).collect();
        assert_eq!(places, [0, 3]);
    }
}
