//! Dates of what is recorded or told: those of the world, or of the stepped clock.
//!
//! The world's clock may be set while the daemon runs. What is to keep its distance in time is
//! noted by moments, which no setting moves, and dated by a [`Calendar`].

use std::time::SystemTime;

use genom_runtime::{Clock, nanos};

/// Gives dates in nanoseconds.
#[derive(Clone, Debug, Default)]
pub struct Dates(Clock);

impl Dates {
    /// Dates for components that live by `clock`.
    pub fn of(clock: &Clock) -> Self {
        Self(clock.clone())
    }

    /// What only goes forward, at the pace of time: from some beginning, or the virtual clock's.
    pub fn moment(&self) -> u64 {
        self.0.now()
    }

    /// Dates of moments, as the world's clock has them now.
    pub fn calendar(&self) -> Calendar {
        /// Readings: this thread may be held up between its looks at the two clocks.
        const READINGS: usize = 8;
        if let Clock::Virtual(_) = &self.0 {
            return Calendar::default();
        }
        let readings = (0..READINGS).map(|_| {
            let (before, date, after) = (self.moment(), self.now(), self.moment());
            let long = after.saturating_sub(before);
            (long, Calendar { shift: date.wrapping_sub(before + long / 2) })
        });
        readings.min_by_key(|(long, _)| *long).unwrap_or_default().1
    }

    /// Since 1970; of a virtual clock, since its start.
    pub fn now(&self) -> u64 {
        match &self.0 {
            Clock::Virtual(clock) => clock.now(),
            Clock::Monotonic => {
                let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
                since.map_or(0, nanos)
            }
        }
    }
}

/// From moments to dates. One calendar's dates are as far apart as the moments, however the
/// world's clock is set meanwhile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calendar {
    shift: u64,
}

impl Calendar {
    /// The date of a moment.
    pub fn date(self, moment: u64) -> u64 {
        moment.wrapping_add(self.shift)
    }

    /// By how many nanoseconds another calendar is ahead of this one.
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
