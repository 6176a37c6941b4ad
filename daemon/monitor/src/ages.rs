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
        self.pasts.iter().map(|past| Some((past.of_one_date()?, past.any()))).collect()
    }

    /// As [`Judge::hear`], if the dates that are noted are so long ago, in the order of
    /// [`Judge::noted`].
    pub fn hear_after(&mut self, letter: usize, ages: &[u64]) -> (Option<usize>, Vec<Noted>) {
        for (past, age) in self.pasts.iter_mut().zip(ages) {
            past.move_to(NOW.saturating_sub(*age));
        }
        let wrong = self.hear(letter, NOW);
        let noted = |past: &Past| match past.date() {
            None => Noted::None,
            Some(NOW) => Noted::Now,
            Some(_) => Noted::Before,
        };
        (wrong, self.pasts.iter().map(noted).collect())
    }
}
