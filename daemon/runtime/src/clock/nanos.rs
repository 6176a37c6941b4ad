//! Times as numbers.

use std::time::Duration;

/// A time in nanoseconds; `u64::MAX` for one that is longer (584 years).
#[must_use]
pub fn nanos(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
