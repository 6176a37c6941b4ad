//! Samples in columns: of each time as wide as a column of a plot the first, the least, the
//! greatest and the last number. However fast samples come, none of them is invisible.

use std::collections::VecDeque;

use genom_protocol::Column;

/// Columns that wait for a client; of more, the latest stay.
const KEPT: usize = 512;

/// The columns of one plot.
#[derive(Debug)]
pub(crate) struct Columns {
    /// Width of a column, in nanoseconds.
    width: u64,
    /// Numbers in a sample.
    numbers: usize,
    /// The one that samples are added to, with its end.
    open: Option<Column>,
    complete: VecDeque<Column>,
    /// Complete ones that were left out.
    skipped: u64,
}

impl Columns {
    pub(crate) fn new(width: u64, numbers: usize) -> Self {
        let complete = VecDeque::new();
        Self { width: width.max(1), numbers, open: None, complete, skipped: 0 }
    }

    /// Adds a sample that was taken at this date. One that is older than the column before it counts
    /// for the present one: dates of a port only grow, but for a clock that was set back.
    pub(crate) fn add(&mut self, date: u64, mut read: impl FnMut(usize) -> Option<f64>) {
        let at = date - date % self.width;
        if self.open.as_ref().is_some_and(|open| open.at < at) {
            self.close();
        }
        let (numbers, empty) = (self.numbers, || Column { at, ..Column::default() });
        let open = self.open.get_or_insert_with(empty);
        open.values.resize(numbers, None);
        open.samples = open.samples.saturating_add(1);
        for (index, value) in open.values.iter_mut().enumerate() {
            let Some(number) = read(index).filter(|number| number.is_finite()) else { continue };
            match value {
                None => *value = Some([number; 4]),
                Some([_, least, greatest, last]) => {
                    *least = least.min(number);
                    *greatest = greatest.max(number);
                    *last = number;
                }
            }
        }
    }

    /// Completes the column of a time that is over at this date.
    pub(crate) fn until(&mut self, date: u64) {
        let over = |open: &Column| open.at.saturating_add(self.width) <= date;
        if self.open.as_ref().is_some_and(over) {
            self.close();
        }
    }

    fn close(&mut self) {
        if self.complete.len() >= KEPT {
            self.complete.pop_front();
            self.skipped += 1;
        }
        self.complete.extend(self.open.take());
    }

    /// The complete columns, which are then not here any more.
    pub(crate) fn take(&mut self) -> Vec<Column> {
        self.complete.drain(..).collect()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.complete.is_empty()
    }

    /// Complete columns that were left out so far.
    pub(crate) fn skipped(&self) -> u64 {
        self.skipped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sample_is_invisible_however_many_share_a_column() {
        let mut columns = Columns::new(100, 1);
        // A spike in each column that is there for one sample of fifty.
        for date in 0..1000_u64 {
            let number = if date % 100 == 37 { 9.0 } else { -(date as f64) };
            columns.add(date, |_| Some(number));
        }
        columns.until(999);
        let taken = columns.take();
        assert_eq!(taken.len(), 9, "the last one is not over");
        for (at, column) in (0..).step_by(100).zip(&taken) {
            let [first, least, greatest, last] = column.values[0].unwrap();
            assert_eq!((column.at, column.samples, greatest), (at, 100, 9.0));
            assert_eq!(
                (first, least, last),
                (-(at as f64), -(at as f64) - 99.0, -(at as f64) - 99.0)
            );
        }
        columns.until(1000);
        assert_eq!(columns.take().len(), 1);
        assert!(columns.is_empty() && columns.skipped() == 0);
    }

    #[test]
    fn what_is_no_finite_number_is_left_out() {
        let mut columns = Columns::new(10, 3);
        for (date, number) in [(0, f64::NAN), (1, 2.0), (2, f64::INFINITY), (3, 1.0)] {
            columns.add(date, |index| match index {
                0 => Some(number),
                1 => Some(f64::NAN),
                _ => None,
            });
        }
        columns.until(10);
        let taken = columns.take();
        assert_eq!(taken[0].values, [Some([2.0, 1.0, 2.0, 1.0]), None, None]);
        assert_eq!(taken[0].samples, 4);
    }

    #[test]
    fn a_time_without_samples_has_no_column_and_a_clock_set_back_loses_none() {
        let mut columns = Columns::new(10, 1);
        for date in [5, 95, 41, 96, 107] {
            columns.add(date, |_| Some(date as f64));
        }
        columns.until(u64::MAX);
        let taken: Vec<_> = columns.take().iter().map(|one| (one.at, one.samples)).collect();
        assert_eq!(taken, [(0, 1), (90, 3), (100, 1)]);
    }

    #[test]
    fn a_client_that_takes_nothing_misses_the_oldest_and_they_are_counted() {
        let mut columns = Columns::new(1, 1);
        let more = 5;
        for date in 0..KEPT as u64 + more + 1 {
            columns.add(date, |_| Some(0.0));
        }
        assert_eq!(columns.skipped(), more);
        let taken = columns.take();
        assert_eq!((taken.len(), taken[0].at), (KEPT, more));
    }
}
