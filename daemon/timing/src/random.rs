//! Numbers that look random, the same ones each time, and how long searches with them go on.

/// A generator of numbers; the same ones each time (xorshift64, Marsaglia 2003).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// A number below `count`; 0 if there is none.
    pub fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 >> 33).unwrap_or(0) % count.max(1)
    }

    /// One of these.
    ///
    /// # Panics
    /// If there is none.
    pub fn one<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// How long searches take, one after the other, that begin anew since they may be lucky or not: mostly
/// the shortest time, and each that is twice as long half as often (Luby, Sinclair, Zuckerman: Optimal
/// Speedup of Las Vegas Algorithms, 1993).
pub fn lengths() -> impl Iterator<Item = u32> {
    (1u32..).map(|number| {
        let mut left = number;
        // The last one of the first `2^k - 1` has the length `2^(k-1)`; what follows are these again.
        while !(left + 1).is_power_of_two() {
            left -= (1 << left.ilog2()) - 1;
        }
        left.div_ceil(2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_searches_come_seldom() {
        let first: Vec<u32> = lengths().take(15).collect();
        assert_eq!(first, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }

    #[test]
    fn numbers_are_the_same_each_time_and_below() {
        let numbers = || {
            let mut random = Random(1);
            (0..100).map(|count| random.below(count)).collect::<Vec<_>>()
        };
        assert_eq!(numbers(), numbers());
        assert!(numbers().iter().zip(0..).all(|(number, count)| *number < 1.max(count)));
    }
}
