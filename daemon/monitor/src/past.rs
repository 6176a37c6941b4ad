//! When something held that a formula asks for: no more dates than its bounds need.

/// Limit on the dates that are kept for one part of a formula.
const MOST_DATES: u64 = 64;

/// How long ago, in nanoseconds: both included; `most` is `u64::MAX` for any time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The least time.
    pub least: u64,
    /// The greatest time.
    pub most: u64,
}

impl Bounds {
    /// Any time.
    pub(crate) const EVER: Self = Self { least: 0, most: u64::MAX };

    /// Whether so long ago is between them.
    #[inline]
    fn are_around(self, ago: u64) -> bool {
        // What is nearer than the least becomes greater than all.
        ago.wrapping_sub(self.least) <= self.most - self.least
    }

    /// Whether one date is not enough to tell whether some date is between them.
    pub(crate) fn of_many_dates(self) -> bool {
        self.least > 0 && self.most < u64::MAX
    }

    /// Dates to be kept. If of three dates the first and the last are no farther from each other
    /// than the two bounds, an interval with the second one has another one, too, so that the
    /// second need not be kept: at most two are within each such interval. `None` if that are too
    /// many, or if the bounds are equal, which nothing is likely to meet.
    pub(crate) fn dates(self) -> Option<usize> {
        match self {
            Self { least: 0, .. } | Self { most: u64::MAX, .. } => Some(1),
            Self { least, most } => {
                let width = most.checked_sub(least).filter(|width| *width > 0)?;
                let dates = 2 * most.div_ceil(width) + 2;
                (dates <= MOST_DATES).then(|| usize::try_from(dates).unwrap_or_default())
            }
        }
    }
}

/// A date at which something held, where one is enough: the last one, which is the nearest, or the
/// first one, which is the farthest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Past {
    date: u64,
    bounds: Bounds,
    /// A date is kept.
    is_there: bool,
    keeps_first: bool,
    /// The part that notes it.
    pub(crate) part: u8,
    /// Which of the lists of dates is its, if it needs one.
    pub(crate) list: Option<u8>,
}

impl Past {
    /// None yet.
    pub(crate) fn new(part: u8, bounds: Bounds, list: Option<u8>) -> Self {
        Self { date: 0, bounds, is_there: false, keeps_first: bounds.least > 0, part, list }
    }

    /// It holds at this date, which is none before those of earlier calls; or, with `false`, what was
    /// noted is gone.
    #[inline]
    pub(crate) fn note(&mut self, holds: bool, now: u64) {
        if !(self.keeps_first && self.is_there) {
            self.date = now;
        }
        self.is_there = holds;
    }

    /// Whether there is a date between the bounds before this one.
    #[inline]
    pub(crate) fn is_within(&self, now: u64) -> bool {
        self.is_there & self.bounds.are_around(now.saturating_sub(self.date))
    }

    pub(crate) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The date that is kept, if one is.
    pub(crate) fn date(&self) -> Option<u64> {
        self.is_there.then_some(self.date)
    }

    /// Puts another date in its place.
    pub(crate) fn move_to(&mut self, date: u64) {
        self.date = date;
    }
}

/// The dates at which something held, for bounds that need more than one.
#[derive(Clone, Debug)]
pub(crate) struct Dates {
    bounds: Bounds,
    /// Of these the first `count`, in order.
    all: Box<[u64]>,
    count: usize,
}

impl Dates {
    pub(crate) fn new(bounds: Bounds) -> Self {
        let room = bounds.dates().unwrap_or(1);
        Self { bounds, count: 0, all: vec![0; room].into_boxed_slice() }
    }

    /// As [`Past::note`].
    pub(crate) fn note(&mut self, holds: bool, now: u64) {
        if holds {
            self.add(now);
        } else {
            self.count = 0;
        }
    }

    fn add(&mut self, now: u64) {
        let over = |date: &&u64| now.saturating_sub(**date) > self.bounds.most;
        let gone = self.all[..self.count].iter().take_while(over).count();
        self.all.copy_within(gone..self.count, 0);
        self.count -= gone;
        let width = self.bounds.most.saturating_sub(self.bounds.least);
        if self.count >= 2 && now.saturating_sub(self.all[self.count - 2]) <= width {
            self.count -= 1;
        }
        if self.count == self.all.len() {
            // Not to be: there is room for all.
            self.all.copy_within(1.., 0);
            self.count -= 1;
        }
        self.all[self.count] = now;
        self.count += 1;
    }

    /// Those that are kept, in order.
    pub(crate) fn all(&self) -> &[u64] {
        &self.all[..self.count]
    }

    /// Puts other dates in their places.
    pub(crate) fn move_to(&mut self, dates: impl Iterator<Item = u64>) {
        self.all[..self.count].iter_mut().zip(dates).for_each(|(date, other)| *date = other);
    }

    /// As [`Past::is_within`].
    pub(crate) fn are_within(&self, now: u64) -> bool {
        let mut ago = self.all[..self.count].iter().map(|date| now.saturating_sub(*date));
        ago.any(|ago| self.bounds.are_around(ago))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn what_is_kept_answers_as_all_dates_would(
            least in 0u64..60,
            width in 1u64..60,
            ever in proptest::bool::weighted(0.2),
            steps in proptest::collection::vec((0u64..9, proptest::bool::ANY), 1..400),
        ) {
            let bounds = Bounds { least, most: if ever { u64::MAX } else { least + width } };
            if let Some(room) = bounds.dates() {
                let (mut dates, mut all, mut now) = (Dates::new(bounds), Vec::new(), 0);
                let mut one = Past::new(0, bounds, None);
                for (step, holds) in steps {
                    now += step;
                    if holds {
                        one.note(true, now);
                        dates.note(true, now);
                        all.push(now);
                    }
                    let within = |date: &u64| (least..=bounds.most).contains(&(now - date));
                    let held = all.iter().any(within);
                    if bounds.of_many_dates() {
                        prop_assert_eq!(dates.are_within(now), held);
                        prop_assert!(dates.count <= room);
                    } else {
                        prop_assert_eq!(one.is_within(now), held);
                    }
                }
            }
        }
    }

    #[test]
    fn bounds_that_need_too_many_dates_are_known() {
        let dates = |least, most| Bounds { least, most }.dates();
        assert_eq!([dates(0, 9), dates(9, u64::MAX)], [Some(1); 2]);
        assert_eq!([dates(1, 2), dates(30, 31)], [Some(6), Some(64)]);
        assert_eq!([dates(31, 32), dates(5, 5)], [None; 2]);
    }
}
