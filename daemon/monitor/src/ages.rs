//! A formula whose dates are others' concern: it is told how long ago each was, and tells what
//! becomes of it. So who explores what may happen judges by the same steps as who hears what happens.

use std::ops::Range;

use crate::judge::{Judge, State};
use crate::past::{Bounds, Past};
use crate::step::What;

/// The present, for ages up to it. A date after it is as near as the present, and not the same.
const NOW: u64 = u64::MAX - 1;

/// What is done about the dates of a part of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Whether one is within the bounds matters.
    pub looks: bool,
    /// One may be added where there may be several: those over the bounds go, and so does the last
    /// one if the one before it is no farther from the new one than the bounds are from each other.
    pub adds: bool,
}

/// The dates that are noted for a part of a formula after something was heard, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Noted {
    /// Which of those of before.
    pub before: Range<usize>,
    /// After these, that of what is heard.
    pub now: bool,
}

impl Noted {
    /// Of these dates, if so many of those of before were over the bounds.
    fn of(dates: &[u64], over: usize) -> Self {
        let now = dates.last() == Some(&NOW);
        // Those that are over go when one is added.
        let first = if now { over } else { 0 };
        Self { before: first..first + dates.len() - usize::from(now), now }
    }
}

impl Judge {
    /// For each part with dates, its bounds, and how many dates are noted; none for any time, which
    /// needs no date.
    #[must_use]
    pub fn noted(&self) -> Vec<(Bounds, usize)> {
        let of = |past: &Past| (past.bounds(), self.state.dates_of(past).len());
        self.state.noted.pasts.iter().map(of).collect()
    }

    /// What is done about the dates of each part when this is heard.
    #[must_use]
    pub fn asked(&self, letter: usize) -> Vec<Asked> {
        let letter = self.letters().get(letter);
        let asked = |(number, past): (u8, &Past)| {
            let does = |which: fn(What) -> Option<u8>| {
                let mut steps = letter.into_iter().flat_map(|letter| &*letter.steps);
                steps.any(|step| which(step.what) == Some(number))
            };
            let at_once = letter.is_some_and(|letter| letter.looked >> (number & 63) & 1 == 1);
            let looks = |what| if let What::Look(part) = what { Some(part) } else { None };
            let notes = |what| if let What::Note(part, true) = what { Some(part) } else { None };
            Asked { looks: at_once || does(looks), adds: past.list.is_some() && does(notes) }
        };
        (0..).zip(&self.state.noted.pasts).map(asked).collect()
    }

    /// As [`Judge::hear`], if the dates that are noted are so long ago, in the order of
    /// [`Judge::noted`], the first one of each part first.
    pub fn hear_after(&mut self, letter: usize, ages: &[Vec<u64>]) -> (Option<usize>, Vec<Noted>) {
        let date = |age: &u64| if *age == 0 { NOW + 1 } else { NOW.saturating_sub(*age) };
        let State { noted, .. } = &mut self.state;
        let mut all_over = Vec::with_capacity(ages.len());
        for (past, ages) in noted.pasts.iter_mut().zip(ages) {
            let list = past.list.and_then(|list| noted.dates.get_mut(usize::from(list)));
            let over = ages.iter().take_while(|age| **age > past.bounds().most).count();
            all_over.push(if list.is_some() { over } else { 0 });
            match (list, ages.first()) {
                (Some(list), _) => list.move_to(ages.iter().map(date)),
                (None, Some(age)) => past.move_to(date(age)),
                (None, None) => {}
            }
        }
        let wrong = self.hear(letter, NOW);
        let all = self.state.noted.pasts.iter().zip(all_over);
        (wrong, all.map(|(past, over)| Noted::of(&self.state.dates_of(past), over)).collect())
    }
}
