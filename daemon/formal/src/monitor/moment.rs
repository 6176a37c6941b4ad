//! A formula with bounds at one moment, for all dates at once: a clock counts how long ago each date
//! was that the judge of the runtime notes, and a zone is cut where a bound tells its values apart.

use std::ops::Range;

use genom_runtime::{Asked, Bounds, Judge};

use crate::codels::small;
use crate::timed::{Clock, bound};
use genom_timing::{Age, Trail, Zone};

/// A formula at one moment, with the clocks that there are.
#[derive(Clone)]
pub(super) struct Moment {
    pub(super) judge: Judge,
    /// Those of dates that the judge has noted are the last ones.
    pub(super) clocks: Vec<Clock>,
    pub(super) zone: Zone,
    /// Where these dates come from, and what they were compared with, since a step began.
    pub(super) trail: Trail,
}

impl Moment {
    /// Where a step begins: with these other clocks, and a zone of these and those of dates.
    pub(super) fn at(judge: Judge, mut clocks: Vec<Clock>, zone: Zone) -> Self {
        let others = clocks.len();
        for (bounds, count) in judge.noted() {
            numbered(&mut clocks, count, bounds);
        }
        let trail = Trail::of(clocks.len() - others);
        Self { judge, clocks, zone, trail }
    }

    /// What is heard under this number happens: where that leads, and whether it breaks the
    /// formula.
    pub(super) fn hear(&self, letter: usize) -> Vec<(Self, bool)> {
        let first = 1 + self.clocks.len() - self.trail.dates.len();
        let mut cases = vec![Case { zone: self.zone.clone(), ages: Vec::new(), is: Vec::new() }];
        let (noted, mut clock) = (self.judge.noted(), first);
        for ((bounds, count), asked) in noted.iter().zip(self.judge.asked(letter)) {
            let dates = (*bounds, asked, clock..clock + count);
            cases = cases.iter().flat_map(|case| cut(case, &dates)).collect();
            clock += count;
        }
        cases.into_iter().map(|case| self.heard(letter, case, (&noted, first))).collect()
    }

    /// The same in this case, of which the first clock of a date is given.
    fn heard(
        &self,
        letter: usize,
        case: Case,
        (all, mut first): (&[(Bounds, usize)], usize),
    ) -> (Self, bool) {
        let mut judge = self.judge.clone();
        let (wrong, noted) = judge.hear_after(letter, &case.ages);
        // A date of this very step is not long ago.
        let others = first;
        let from = |clock: usize| self.trail.dates.get(clock - others).copied().flatten();
        let is = case.is.iter().filter_map(|(clock, age)| Some((from(*clock)?, *age)));
        let mut trail = Trail { dates: Vec::new(), ages: self.trail.ages.clone() };
        trail.ages.extend(is);
        let mut clocks = self.clocks[..first - 1].to_vec();
        let mut sources: Vec<Option<usize>> = (1..first).map(Some).collect();
        for ((bounds, count), noted) in all.iter().zip(noted) {
            let kept = noted.before.map(|at| Some(first + at)).chain(noted.now.then_some(None));
            let length = sources.len();
            sources.extend(kept);
            numbered(&mut clocks, sources.len() - length, *bounds);
            first += count;
        }
        let dates = sources[others - 1..].iter();
        trail.dates =
            dates.map(|clock| self.trail.dates.get((*clock)? - others).copied()?).collect();
        (Self { judge, clocks, zone: case.zone.select(&sources), trail }, wrong.is_some())
    }

    /// The clocks of the formula.
    pub(super) fn noted(&self) -> &[Clock] {
        &self.clocks[self.clocks.len() - self.trail.dates.len()..]
    }
}

/// Adds clocks of so many dates with these bounds.
fn numbered(clocks: &mut Vec<Clock>, count: usize, bounds: Bounds) {
    let numbers = clocks.len()..clocks.len() + count;
    clocks.extend(numbers.map(|at| Clock::Noted(small(at), greatest(bounds))));
}

/// The greatest time that a date is compared with. Dates are whole nanoseconds.
fn greatest(bounds: Bounds) -> u64 {
    if bounds.most == u64::MAX { bounds.least } else { bounds.most.saturating_add(1) }
}

/// A part of a zone in which all dates lead to the same.
#[derive(Clone)]
struct Case {
    zone: Zone,
    /// An age of each date there, for each part of the formula.
    ages: Vec<Vec<u64>>,
    /// By which ages of dates it is a part, with the clocks of these.
    is: Vec<(usize, Age)>,
}

impl Case {
    /// Where a clock is below a time, and where it has reached it.
    fn parted(&self, clock: usize, time: u64) -> (Option<Self>, Option<Self>) {
        let (mut below, mut reached) = (self.clone(), self.clone());
        let is_below = time > 0 && below.zone.at_most(clock, bound(time - 1));
        let has_reached = reached.zone.at_least(clock, bound(time));
        below.is.push((clock, Age::Most(time.saturating_sub(1))));
        reached.is.push((clock, Age::Least(time)));
        (is_below.then_some(below), has_reached.then_some(reached))
    }

    /// With these ages of the dates of one more part.
    fn with(mut self, ages: &[u64]) -> Self {
        self.ages.push(ages.to_vec());
        self
    }
}

/// A case in parts in which all dates of one more part of a formula lead to the same. They are in
/// order, so that one is within the bounds if the first one is that is not over them.
fn cut(case: &Case, (bounds, asked, dates): &(Bounds, Asked, Range<usize>)) -> Vec<Case> {
    let mut ages = vec![0; dates.len()];
    if !asked.looks && !asked.adds {
        return vec![case.clone().with(&ages)];
    }
    let (mut all, mut rest) = (Vec::new(), case.clone());
    for (at, clock) in dates.clone().enumerate() {
        let (not_over, over) = match bounds.most {
            u64::MAX => (Some(rest.clone()), None),
            most => rest.parted(clock, most.saturating_add(1)),
        };
        let looked = match not_over {
            Some(case) if asked.looks => {
                let (nearer, within) = case.parted(clock, bounds.least);
                [(nearer, 0), (within, bounds.least)]
            }
            case => [(case, 0), (None, 0)],
        };
        for (case, age) in looked {
            let Some(case) = case else { continue };
            ages[at] = age;
            // The last one but one, which tells whether the last one goes.
            let Some(last) = dates.len().checked_sub(2).filter(|last| asked.adds && *last >= at)
            else {
                all.push(case.with(&ages));
                continue;
            };
            let width = bounds.most - bounds.least;
            let (near, far) = case.parted(dates.start + last, width + 1);
            all.extend(near.map(|case| case.with(&ages)));
            let mut ages = ages.clone();
            ages[last] = ages[last].max(width + 1);
            all.extend(far.map(|case| case.with(&ages)));
        }
        ages[at] = greatest(*bounds);
        let Some(case) = over else { return all };
        rest = case;
    }
    all.push(rest.with(&ages));
    all
}

#[cfg(test)]
#[path = "../../tests/unit/moment.rs"]
mod tests;
