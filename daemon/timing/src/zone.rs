//! Zones: sets of values of clocks, as bounds on their differences (Bengtsson, Yi: Timed Automata:
//! Semantics, Algorithms and Tools, 2004). All bounds are closed.

/// No bound.
const NONE: i64 = i64::MAX;

/// A set of values of clocks. Clock 0 is always zero. Always closed: each bound is the least that
/// follows from all others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zone {
    size: usize,
    /// For clocks `i` and `j`, the greatest value of `i - j`, row by row.
    bounds: Box<[i64]>,
}

/// What later steps compare a clock with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Guards {
    /// The greatest value that it has to have reached.
    pub least: Option<i64>,
    /// The greatest value that it must not pass.
    pub most: Option<i64>,
    /// It may pass it all the same: a step only tells values up to it apart.
    pub passes: bool,
}

fn sum(a: i64, b: i64) -> i64 {
    if a == NONE || b == NONE { NONE } else { a + b }
}

impl Zone {
    /// The zone of one point: clock `i + 1` has the value `values[i]`.
    #[must_use]
    pub fn point(values: &[i64]) -> Self {
        let size = values.len() + 1;
        let value = |clock: usize| if clock == 0 { 0 } else { values[clock - 1] };
        let bounds = (0..size * size).map(|at| value(at / size) - value(at % size)).collect();
        Self { size, bounds }
    }

    fn bound(&self, i: usize, j: usize) -> i64 {
        self.bounds[i * self.size + j]
    }

    /// The greatest value of a clock.
    #[must_use]
    pub fn most(&self, clock: usize) -> Option<i64> {
        Some(self.bound(clock, 0)).filter(|bound| *bound != NONE)
    }

    /// Keeps the values with `i - j` at most `bound`; `false` when none is left.
    #[must_use]
    pub fn keep(&mut self, i: usize, j: usize, bound: i64) -> bool {
        if sum(self.bound(j, i), bound) < 0 {
            return false;
        }
        if bound >= self.bound(i, j) {
            return true;
        }
        self.bounds[i * self.size + j] = bound;
        // Only ways over the new bound can be shorter than before.
        for a in 0..self.size {
            let to = sum(self.bound(a, i), bound);
            if to == NONE {
                continue;
            }
            for b in 0..self.size {
                let way = sum(to, self.bound(j, b));
                if way < self.bound(a, b) {
                    self.bounds[a * self.size + b] = way;
                }
            }
        }
        true
    }

    /// Keeps the values of a clock that are at least `bound`.
    #[must_use]
    pub fn at_least(&mut self, clock: usize, bound: i64) -> bool {
        self.keep(0, clock, -bound)
    }

    /// Keeps the values of a clock that are at most `bound`.
    #[must_use]
    pub fn at_most(&mut self, clock: usize, bound: i64) -> bool {
        self.keep(clock, 0, bound)
    }

    /// Time passes, for as long as one likes.
    pub fn up(&mut self) {
        for clock in 1..self.size {
            self.bounds[clock * self.size] = NONE;
        }
    }

    /// Adds values that no guard tells from those that are there, or from which less is possible:
    /// `least` and `most` are the greatest values that later steps compare each clock with, from
    /// below and from above (Behrmann, Bouyer, Larsen, Pelanek: Lower and Upper Bounds in Zone-Based
    /// Abstractions of Timed Automata, 2006). Values beyond `most` are left
    /// out, unless the clock may pass it.
    pub fn extrapolate(&mut self, guards: &[Guards]) {
        let size = self.size;
        let at_least: Vec<i64> = (0..size).map(|clock| -self.bound(0, clock)).collect();
        let mut changed = false;
        for i in 0..size {
            for j in 0..size {
                if i == j {
                    continue;
                }
                let bound = self.bound(i, j);
                let above = i > 0 && {
                    let least = guards[i - 1].least;
                    least.is_none_or(|least| bound > least || at_least[i] > least)
                };
                let free = j > 0 && guards[j - 1].most.is_none_or(|most| at_least[j] > most);
                let wider = match (i > 0 && (above || free), free) {
                    (true, _) => NONE,
                    (false, true) => -guards[j - 1].most.unwrap_or(0),
                    (false, false) => continue,
                };
                changed |= wider != bound;
                self.bounds[i * size + j] = wider;
            }
        }
        for (clock, guards) in (1..size).zip(guards) {
            if let Some(most) = guards.most.filter(|_| !guards.passes) {
                let bound = &mut self.bounds[clock * size];
                changed |= most < *bound;
                *bound = (*bound).min(most);
            }
        }
        if changed {
            self.close();
        }
    }

    /// Makes each bound the least that follows from all others.
    fn close(&mut self) {
        for over in 0..self.size {
            for i in 0..self.size {
                let to = self.bound(i, over);
                if to == NONE || i == over {
                    continue;
                }
                for j in 0..self.size {
                    let way = sum(to, self.bound(over, j));
                    if way < self.bound(i, j) {
                        self.bounds[i * self.size + j] = way;
                    }
                }
            }
        }
    }

    /// The greatest value of a clock less another one.
    #[must_use]
    pub fn difference(&self, i: usize, j: usize) -> Option<i64> {
        Some(self.bound(i, j)).filter(|bound| *bound != NONE)
    }

    /// Clock by clock, the one of this zone that it is (from 1), or `None` for a new one at zero.
    #[must_use]
    pub fn select(&self, clocks: &[Option<usize>]) -> Self {
        let size = clocks.len() + 1;
        let mut bounds = Vec::with_capacity(size * size);
        let old = || std::iter::once(0).chain(clocks.iter().map(|clock| clock.unwrap_or(0)));
        for i in old() {
            let row = &self.bounds[i * self.size..][..self.size];
            bounds.extend(old().map(|j| row[j]));
        }
        Self { size, bounds: bounds.into_boxed_slice() }
    }

    /// Whether all values of `other` are in this zone.
    #[must_use]
    pub fn includes(&self, other: &Self) -> bool {
        self.bounds.iter().zip(&other.bounds).all(|(mine, theirs)| theirs <= mine)
    }

    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.bounds.len() * size_of::<i64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_passes_for_all_clocks_alike() {
        let mut zone = Zone::point(&[0, 3]);
        zone.up();
        assert!(zone.at_most(1, 5));
        assert_eq!([zone.most(1), zone.most(2)], [Some(5), Some(8)]);
        assert!(zone.at_least(2, 7));
        // The first clock has then passed 4 as well.
        assert!(!zone.clone().at_most(1, 3) && zone.at_most(1, 4));
    }

    #[test]
    fn a_new_clock_is_zero_and_the_others_stay() {
        let mut zone = Zone::point(&[0, 3]);
        zone.up();
        assert!(zone.at_most(1, 5) && zone.at_least(1, 5));
        let next = zone.select(&[Some(2), None]);
        assert_eq!([next.most(1), next.most(2)], [Some(8), Some(0)]);
        assert!(!next.clone().at_least(2, 1) && next.clone().at_least(1, 8));
    }

    #[test]
    fn what_began_later_can_do_all_that_what_began_before_can() {
        let guards = |least| {
            let guards = |least, most| Guards { least, most: Some(most), passes: false };
            [guards(Some(10), 10), guards(least, 5)]
        };
        // A clock that ends by 5, begun when the other one was at 2, and at 3; both seen from 3 on.
        let began = |date: i64, least: Option<i64>| {
            let mut zone = Zone::point(&[date, 0]);
            zone.up();
            assert!(zone.at_least(1, 3) && zone.at_most(1, 10) && zone.at_most(2, 5));
            zone.extrapolate(&guards(least));
            zone
        };
        assert_eq!(began(3, None).most(1), Some(8));
        assert!(began(3, None).includes(&began(2, None)));
        assert!(!began(2, None).includes(&began(3, None)));
        // Not so if it must last for a time.
        assert!(!began(3, Some(4)).includes(&began(2, Some(4))));
    }

    #[test]
    fn a_zone_includes_its_parts() {
        let mut all = Zone::point(&[0]);
        all.up();
        let mut part = all.clone();
        assert!(part.at_least(1, 2) && part.at_most(1, 3));
        assert!(all.includes(&part) && !part.includes(&all));
    }

    #[test]
    fn a_clock_that_may_pass_its_bound_keeps_the_values_beyond_it() {
        let guards = |passes| [Guards { least: Some(5), most: Some(5), passes }];
        for (passes, most) in [(true, None), (false, Some(5))] {
            let mut zone = Zone::point(&[3]);
            zone.up();
            zone.extrapolate(&guards(passes));
            assert_eq!(zone.most(1), most);
        }
    }
}
