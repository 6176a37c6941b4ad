//! Dates that something keeps along a run, and how long ago they are where that matters.

use crate::dates::AtLeast;
use crate::memory::{PIECE, listed};

/// How long ago a date is, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Age {
    /// At least this.
    Least(u64),
    /// At most this.
    Most(u64),
}

impl Age {
    fn rule(self, now: usize, then: usize) -> AtLeast {
        let ns = |ns| i64::try_from(ns).unwrap_or(i64::MAX);
        match self {
            Self::Least(least) => AtLeast { later: now, earlier: then, by: ns(least) },
            Self::Most(most) => AtLeast { later: then, earlier: now, by: -ns(most) },
        }
    }
}

/// What a step makes of the dates that are kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trail {
    /// Those that are kept after it: each by its place among those of before, or `None` for that of
    /// the step.
    pub dates: Vec<Option<usize>>,
    /// How long ago some of those of before are at the step.
    pub ages: Vec<(usize, Age)>,
}

impl Trail {
    /// So many dates stay.
    #[must_use]
    pub fn of(count: usize) -> Self {
        Self { dates: (0..count).map(Some).collect(), ages: Vec::new() }
    }

    /// Bytes that it takes in a list, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let dates = self.dates.capacity() * size_of::<Option<usize>>();
        let ages = self.ages.capacity() * size_of::<(usize, Age)>();
        listed::<Self>() + 2 * PIECE + dates + ages
    }
}

/// What the ages at the steps of a run say of their dates, by the numbers of the steps from 0 on.
pub fn along<'t>(steps: impl IntoIterator<Item = &'t Trail>) -> Vec<AtLeast> {
    let (mut kept, mut rules) = (Vec::<usize>::new(), Vec::new());
    for (now, step) in steps.into_iter().enumerate() {
        let then = |date: &usize| kept.get(*date).copied();
        rules.extend(step.ages.iter().filter_map(|(date, age)| Some(age.rule(now, then(date)?))));
        let dates = step.dates.iter().map(|from| from.as_ref().map_or(Some(now), then));
        kept = dates.map(Option::unwrap_or_default).collect();
    }
    rules
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dates::earliest;

    #[test]
    fn a_date_is_followed_through_the_steps_in_which_it_stays() {
        let step = |dates: &[Option<usize>], ages: &[(usize, Age)]| Trail {
            dates: dates.to_vec(),
            ages: ages.to_vec(),
        };
        // Noted at the steps 1 and 2; the first is forgotten at 3, where it is 5 ago; at 4 the second
        // one is between 7 and 7 ago.
        let steps = [
            step(&[], &[]),
            step(&[None], &[]),
            step(&[Some(0), None], &[]),
            step(&[Some(1)], &[(0, Age::Least(5))]),
            step(&[], &[(0, Age::Least(7)), (0, Age::Most(7))]),
        ];
        let mut rules = along(&steps);
        rules.push(AtLeast { later: 2, earlier: 0, by: 1 });
        assert_eq!(earliest(5, &rules), [0, 0, 1, 5, 8]);
    }
}
