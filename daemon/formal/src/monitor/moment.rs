//! A formula with bounds at one moment, for all dates at once: a clock counts how long ago each date
//! was that the judge of the runtime notes, and a zone is cut where a bound tells its values apart.

use genom_runtime::{Bounds, Judge, Noted};

use crate::codels::small;
use crate::timed::{Clock, bound};
use genom_timing::Zone;

const ANY: Bounds = Bounds { least: 0, most: u64::MAX };

/// A formula at one moment, with the clocks that there are.
#[derive(Clone)]
pub(super) struct Moment {
    pub(super) judge: Judge,
    pub(super) clocks: Vec<Clock>,
    pub(super) zone: Zone,
}

impl Moment {
    /// What is heard under this number happens: where that leads, and whether it breaks the
    /// formula. `None` if some part needs more than one date.
    pub(super) fn hear(&self, letter: usize) -> Option<Vec<(Self, bool)>> {
        let noted = self.judge.noted()?;
        let mut cases = vec![(self.zone.clone(), Vec::new())];
        for (part, (bounds, is_there)) in (0u16..).zip(&noted) {
            let clock = Clock::Noted(part, greatest(*bounds));
            let at = self.clocks.iter().position(|known| *known == clock);
            let Some(at) = at.filter(|_| *is_there) else {
                cases.iter_mut().for_each(|(_, ages)| ages.push(1));
                continue;
            };
            cases = cases.iter().flat_map(|case| cut(case, at + 1, *bounds)).collect();
        }
        let case = |(zone, ages): (Zone, Vec<u64>)| self.heard(letter, zone, &ages, &noted);
        Some(cases.into_iter().map(case).collect())
    }

    /// The same, where the dates are so long ago, as far as the bounds tell.
    fn heard(
        &self,
        letter: usize,
        zone: Zone,
        ages: &[u64],
        all: &[(Bounds, bool)],
    ) -> (Self, bool) {
        let mut judge = self.judge.clone();
        let (wrong, noted) = judge.hear_after(letter, ages);
        let of_formula = |clock: &Clock| matches!(clock, Clock::Noted(..));
        let others = self.clocks.iter().zip(1..).filter(|(clock, _)| !of_formula(clock));
        let (mut clocks, mut sources): (Vec<Clock>, Vec<Option<usize>>) =
            others.map(|(clock, at)| (*clock, Some(at))).unzip();
        for ((part, (bounds, _)), noted) in (0u16..).zip(all).zip(noted) {
            if noted == Noted::None || *bounds == ANY {
                continue;
            }
            let clock = Clock::Noted(part, greatest(*bounds));
            let before = self.clocks.iter().position(|known| *known == clock);
            clocks.push(clock);
            sources.push(before.filter(|_| noted == Noted::Before).map(|at| at + 1));
        }
        (Self { judge, clocks, zone: zone.select(&sources) }, wrong.is_some())
    }

    /// Adds the clocks of the dates that the judge has noted.
    pub(super) fn add_noted(&mut self) {
        let noted = self.judge.noted().unwrap_or_default();
        let own = (0u16..).zip(noted).filter(|(_, (bounds, there))| *there && *bounds != ANY);
        self.clocks.extend(own.map(|(part, (bounds, _))| Clock::Noted(part, greatest(bounds))));
    }

    /// The clocks of the formula.
    pub(super) fn noted(&self) -> impl Iterator<Item = Clock> + '_ {
        self.clocks.iter().filter(|clock| matches!(clock, Clock::Noted(..))).copied()
    }
}

/// The greatest time that a date is compared with. Dates are whole nanoseconds.
fn greatest(bounds: Bounds) -> u64 {
    if bounds.least == 0 { bounds.most.saturating_add(1) } else { bounds.least }
}

/// A zone on both sides of a bound, each with a time of that side.
fn cut(
    (zone, ages): &(Zone, Vec<u64>),
    clock: usize,
    bounds: Bounds,
) -> impl Iterator<Item = (Zone, Vec<u64>)> {
    let above = greatest(bounds);
    let below = above.saturating_sub(1);
    let (mut nearer, mut farther) = (zone.clone(), zone.clone());
    let nearer = nearer.at_most(clock, bound(below)).then_some((nearer, below));
    let farther = farther.at_least(clock, bound(above)).then_some((farther, above));
    let ages = ages.clone();
    nearer.into_iter().chain(farther).map(move |(zone, age)| {
        let ages = ages.iter().copied().chain([age]).collect();
        (zone, ages)
    })
}

/// The clocks that a formula has at most.
pub(super) fn most_clocks(judge: &Judge) -> Option<u16> {
    let bounded = judge.noted()?.iter().filter(|(bounds, _)| *bounds != ANY).count();
    Some(small(bounded))
}

#[cfg(test)]
#[path = "../../tests/unit/moment.rs"]
mod tests;
