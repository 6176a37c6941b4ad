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

/// The dates at which something held.
#[derive(Clone, Debug)]
pub(crate) struct Past {
    bounds: Bounds,
    kept: Kept,
    /// How many dates are kept.
    count: usize,
    /// The date that is kept, where one is enough.
    date: u64,
    /// Otherwise, of these the first `count`, in order.
    dates: Box<[u64]>,
}

/// Which dates are kept.
#[derive(Clone, Copy, Debug)]
enum Kept {
    /// The last one, which is the nearest.
    Last,
    /// The first one, which is the farthest.
    First,
    /// Those that bounds so far from each other need.
    Between(u64),
}

impl Past {
    pub(crate) fn new(bounds: Bounds) -> Self {
        let (kept, room) = match bounds {
            Bounds { least: 0, .. } => (Kept::Last, 0),
            Bounds { most: u64::MAX, .. } => (Kept::First, 0),
            Bounds { least, most } => {
                (Kept::Between(most.saturating_sub(least)), bounds.dates().unwrap_or(1))
            }
        };
        Self { bounds, kept, count: 0, date: 0, dates: vec![0; room].into_boxed_slice() }
    }

    /// It holds at this date, which is none before those of earlier calls.
    #[inline]
    pub(crate) fn add(&mut self, now: u64) {
        match self.kept {
            Kept::First if self.count > 0 => {}
            Kept::Last | Kept::First => (self.date, self.count) = (now, 1),
            Kept::Between(width) => self.add_between(now, width),
        }
    }

    fn add_between(&mut self, now: u64, width: u64) {
        let over = |date: &&u64| now.saturating_sub(**date) > self.bounds.most;
        let gone = self.dates[..self.count].iter().take_while(over).count();
        self.dates.copy_within(gone..self.count, 0);
        self.count -= gone;
        if self.count >= 2 && now.saturating_sub(self.dates[self.count - 2]) <= width {
            self.count -= 1;
        }
        if self.count == self.dates.len() {
            // Not to be: there is room for all.
            self.dates.copy_within(1.., 0);
            self.count -= 1;
        }
        self.dates[self.count] = now;
        self.count += 1;
    }

    /// At an event: whether it held between the bounds before, unless `stays` did not hold at some
    /// event after that.
    #[inline]
    pub(crate) fn goes_on(&mut self, stays: bool, holds: bool, now: u64) -> bool {
        if !stays {
            self.count = 0;
        }
        if holds {
            self.add(now);
        }
        self.held(now)
    }

    /// Its bounds, if one date is enough for them.
    pub(crate) fn of_one_date(&self) -> Option<Bounds> {
        (!matches!(self.kept, Kept::Between(_))).then_some(self.bounds)
    }

    /// The date that is kept, if there is one and one is enough.
    pub(crate) fn date(&self) -> Option<u64> {
        (self.count > 0).then_some(self.date)
    }

    /// Puts another date in the place of the one that is kept.
    pub(crate) fn move_to(&mut self, date: u64) {
        self.date = date;
    }

    /// Whether it held at any date that counts.
    pub(crate) fn any(&self) -> bool {
        self.count > 0
    }

    /// Whether it held between the bounds before this date.
    #[inline]
    pub(crate) fn held(&self, now: u64) -> bool {
        let Bounds { least, most } = self.bounds;
        let within = |date: &u64| {
            let ago = now.saturating_sub(*date);
            least <= ago && ago <= most
        };
        match self.kept {
            Kept::Last | Kept::First => self.count > 0 && within(&self.date),
            Kept::Between(_) => self.dates[..self.count].iter().any(within),
        }
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
                let (mut past, mut all, mut now) = (Past::new(bounds), Vec::new(), 0);
                for (step, holds) in steps {
                    now += step;
                    if holds {
                        past.add(now);
                        all.push(now);
                    }
                    let within = |date: &u64| (least..=bounds.most).contains(&(now - date));
                    prop_assert_eq!(past.held(now), all.iter().any(within));
                    prop_assert!(past.count <= room);
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
