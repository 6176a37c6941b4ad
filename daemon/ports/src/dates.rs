//! Dates of recorded samples and events: wall-clock time, or time of the virtual clock.
//!
//! The wall clock may be set while the daemon runs. Where intervals have to stay correct, a
//! *moment* of the monotonic clock is stored, and a [`Calendar`] converts it to a date.

use std::time::SystemTime;

use genom_runtime::{Clock, nanos};

/// Source of dates and moments, in nanoseconds.
#[derive(Clone, Debug, Default)]
pub struct Dates(Clock);

impl Dates {
    /// Dates for components that run on `clock`.
    pub fn of(clock: &Clock) -> Self {
        Self(clock.clone())
    }

    /// Whether time stands still between steps: dates are moments then.
    pub fn is_stepped(&self) -> bool {
        !matches!(self.0, Clock::Monotonic)
    }

    /// Monotonic time, in nanoseconds since an arbitrary origin; with a virtual clock, since its
    /// start.
    pub fn moment(&self) -> u64 {
        self.0.now()
    }

    /// The conversion from moments to dates, according to the wall clock as it is set now.
    pub fn calendar(&self) -> Calendar {
        /// Both clocks are read this often and the closest pair is used: the thread may be
        /// preempted between the two readings.
        const READINGS: usize = 8;
        if self.is_stepped() {
            return Calendar::default();
        }
        let readings = (0..READINGS).map(|_| {
            let (before, date, after) = (self.moment(), self.now(), self.moment());
            let long = after.saturating_sub(before);
            (long, Calendar { shift: date.wrapping_sub(before + long / 2) })
        });
        readings.min_by_key(|(long, _)| *long).unwrap_or_default().1
    }

    /// The date, in nanoseconds since 1970; with a virtual clock, since its start.
    pub fn now(&self) -> u64 {
        if self.is_stepped() {
            return self.moment();
        }
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        since.map_or(0, nanos)
    }
}

/// Converts moments to dates. Differences between dates of one calendar equal those of the moments,
/// even if the wall clock is set in between.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calendar {
    shift: u64,
}

impl Calendar {
    /// The date of a moment, in nanoseconds.
    pub fn date(self, moment: u64) -> u64 {
        moment.wrapping_add(self.shift)
    }

    /// Difference `other - self` between the dates that two calendars give one moment, in
    /// nanoseconds.
    pub fn until(self, other: Self) -> i64 {
        other.shift.wrapping_sub(self.shift).cast_signed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calendar_keeps_distances_and_tells_by_how_much_another_differs() {
        let (before, after) = (Calendar { shift: 1_000 }, Calendar { shift: 600 });
        assert_eq!((before.date(5), before.date(9)), (1_005, 1_009));
        assert_eq!((before.until(after), after.until(before)), (-400, 400));
        let early = Calendar { shift: 5_u64.wrapping_sub(90) };
        assert_eq!(early.date(100), 15);
        let dates = Dates::default();
        let now = dates.calendar().date(dates.moment());
        assert!(now > 1_000_000_000_000_000_000, "{now} is long past");
    }
}
