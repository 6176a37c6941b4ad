//! Limits of the axis.

use std::ops::RangeInclusive;

/// Period of task `main`, s.
pub(crate) const PERIOD: f64 = 0.005;
/// Acceleration and deceleration, m/s².
pub(crate) const ACCELERATION: f64 = 2.0;
/// Speed before the first `set_speed`, m/s.
pub(crate) const SPEED: f64 = 0.5;
/// Speeds that `set_speed` accepts, m/s.
pub(crate) const SPEEDS: RangeInclusive<f64> = 0.0..=2.0;
/// Positions that `goto` accepts, m.
pub(crate) const GOALS: RangeInclusive<f64> = -10.0..=10.0;
