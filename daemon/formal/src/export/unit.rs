//! The unit that clocks of a model count in.

use crate::system::System;
use crate::timed::Times;
use genom_timing::gcd;

/// The greatest time, in nanoseconds, of which all times are multiples.
pub(super) fn unit(system: &System, times: &Times) -> u64 {
    let ticks = system.periods.iter().flatten();
    let all = times.codels.iter().flat_map(|d| [d.least, d.most.unwrap_or(0)]);
    let all = all.chain(ticks.flat_map(|period| [period.period, period.delay]));
    all.fold(0, gcd).max(1)
}
