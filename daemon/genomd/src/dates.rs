//! Dates of what is recorded or told: those of the world, or of the stepped clock.

use std::time::SystemTime;

use genom_runtime::Clock;

/// Gives dates in nanoseconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dates(Clock);

impl Dates {
    /// Dates for components that live by `clock`.
    pub(crate) fn of(clock: &Clock) -> Self {
        Self(clock.clone())
    }

    /// Since 1970; of a virtual clock, since its start.
    pub(crate) fn now(&self) -> u64 {
        match &self.0 {
            Clock::Virtual(clock) => clock.now(),
            Clock::Monotonic => {
                let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
                since.map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(u64::MAX))
            }
        }
    }
}
