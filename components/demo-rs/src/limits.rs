//! What the axis can do.

use std::ops::RangeInclusive;

/// Period of task `main`, s.
pub(crate) const PERIOD: f64 = 0.005;
/// To speed up and to slow down, m/s^2.
pub(crate) const ACCELERATION: f64 = 2.0;
/// Speed until `set_speed`, m/s.
pub(crate) const SPEED: f64 = 0.5;
/// Speeds that `set_speed` accepts, m/s.
pub(crate) const SPEEDS: RangeInclusive<f64> = 0.0..=2.0;
/// Positions that `goto` accepts, m.
pub(crate) const GOALS: RangeInclusive<f64> = -10.0..=10.0;
