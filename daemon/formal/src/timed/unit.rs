//! The unit that clocks of a model count in.

use super::times::Times;
use crate::system::System;
use genom_timing::gcd;

impl Times {
    /// The greatest time, in nanoseconds, of which these and all periods and delays are multiples.
    #[must_use]
    pub fn unit(&self, system: &System) -> u64 {
        let ticks = system.periods.iter().flatten();
        let all = self.codels.iter().flat_map(|d| [d.least, d.most.unwrap_or(0)]);
        let all = all.chain(ticks.flat_map(|period| [period.period, period.delay]));
        all.fold(0, gcd).max(1)
    }
}
