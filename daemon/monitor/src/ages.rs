//! A formula whose dates are others' concern: it is told how long ago each was, and tells what
//! becomes of it. So who explores what may happen judges by the same steps as who hears what happens.

use crate::judge::Judge;
use crate::past::{Bounds, Past};

/// The present, for ages up to it.
const NOW: u64 = u64::MAX - 1;

/// The date that is noted for a part of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noted {
    /// None.
    None,
    /// That of before.
    Before,
    /// That of what is heard.
    Now,
}

impl Judge {
    /// For each part with dates, its bounds, and whether a date is noted; `None` if some part needs
    /// more than one.
    #[must_use]
    pub fn noted(&self) -> Option<Vec<(Bounds, bool)>> {
        let noted = |past: &Past| {
            let bounds = past.bounds();
            (!bounds.of_many_dates()).then(|| (bounds, self.state.has_noted(past)))
        };
        self.state.noted.pasts.iter().map(noted).collect()
    }

    /// As [`Judge::hear`], if the dates that are noted are so long ago, in the order of
    /// [`Judge::noted`].
    pub fn hear_after(&mut self, letter: usize, ages: &[u64]) -> (Option<usize>, Vec<Noted>) {
        for (past, age) in self.state.noted.pasts.iter_mut().zip(ages) {
            past.move_to(NOW.saturating_sub(*age));
        }
        let wrong = self.hear(letter, NOW);
        let noted = |past: &Past| match past.date() {
            Some(NOW) => Noted::Now,
            _ if self.state.has_noted(past) => Noted::Before,
            _ => Noted::None,
        };
        (wrong, self.state.noted.pasts.iter().map(noted).collect())
    }
}
