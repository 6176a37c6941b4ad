//! Durations as numbers.

use std::time::Duration;

/// A duration in nanoseconds; `u64::MAX` (584 years) for a longer one.
#[must_use]
pub fn nanos(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
