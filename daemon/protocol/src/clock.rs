//! The clock of the components, and the steps of a virtual one.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use strum::Display;

/// The kind of clock that components use.
#[derive(Clone, Copy, Debug, Default, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum ClockKind {
    /// The machine's monotonic clock.
    #[default]
    Monotonic,
    /// A clock that advances only when it is stepped: equal inputs give equal calls of codels.
    Virtual,
    /// A virtual clock that goes on as ROS 2's topic `/clock` says: the time of a simulator.
    Ros,
}

impl ClockKind {
    /// Whether it advances only when it is stepped, by requests or by another clock.
    #[must_use]
    pub fn is_stepped(self) -> bool {
        self != Self::Monotonic
    }
}

/// Advances the virtual clock.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct StepRequest {
    /// How far to advance, in nanoseconds; at most [`StepRequest::LONGEST`]. 0 runs what is due
    /// now.
    #[cfg_attr(feature = "openapi", schema(maximum = 3_600_000_000_000_i64))]
    #[serde(deserialize_with = "whole")]
    pub nanoseconds: u64,
}

impl StepRequest {
    /// The longest step, in nanoseconds (one hour). Make several steps for more.
    pub const LONGEST: u64 = 3_600_000_000_000;
}

/// A whole number; JSON may write it as `2.0`, too.
fn whole<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    let number = serde_json::Number::deserialize(from)?;
    let real = number.as_f64().filter(|real| real.fract() == 0.0 && (0.0..1e18).contains(real));
    number
        .as_u64()
        .or(real.map(|real| real as u64))
        .ok_or_else(|| D::Error::custom(format_args!("{number} is no number of nanoseconds")))
}

/// The clock of the components.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Clock {
    /// Its kind.
    pub clock: ClockKind,
    /// Its time, in nanoseconds.
    pub now: u64,
}
