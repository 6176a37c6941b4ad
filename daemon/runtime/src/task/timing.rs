//! Dates of a task's ticks (genom3.md 7.4).

/// Time within which an aperiodic task is to respond, in nanoseconds; it has no period that would
/// say.
pub(crate) const RESPONSE: u64 = 10_000_000;

/// Ticks of a periodic task: at `epoch + delay + n * period`, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Timing {
    /// Date of a tick, modulo the period.
    base: u64,
    pub(crate) period: u64,
}

impl Timing {
    /// `delay` is a phase within the period: `n % (period/rate) == delay/rate`.
    pub(crate) fn new(epoch: u64, period: u64, delay: u64) -> Self {
        let period = period.max(1);
        Self { base: epoch + delay % period, period }
    }

    /// Date of the first tick after this date.
    pub(crate) fn after(&self, date: u64) -> u64 {
        match date.checked_sub(self.base) {
            Some(since) => self.base + (since / self.period + 1) * self.period,
            None => self.base,
        }
    }

    /// Number of ticks until `date`, including the first one.
    pub(crate) fn count(&self, date: u64) -> u64 {
        date.checked_sub(self.base).map_or(0, |since| since / self.period + 1)
    }

    /// Number of ticks after the one at `tick`, until `date`.
    pub(crate) fn since(&self, tick: u64, date: u64) -> u64 {
        date.saturating_sub(tick) / self.period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delay_is_a_phase_within_the_period() {
        let timing = Timing::new(100, 10, 13);
        assert_eq!(timing.after(100), 103);
        assert_eq!(timing.after(103), 113);
        assert_eq!(timing.after(112), 113);
        assert_eq!(timing.after(0), 103);
    }
    #[test]
    fn ticks_that_came_after_one_are_counted_up_to_a_date() {
        let timing = Timing::new(100, 10, 3);
        // Served at 103 or a little later, none is missed; nor is one before the tick.
        assert_eq!([103, 112, 95].map(|date| timing.since(103, date)), [0, 0, 0]);
        // Served not before 113 or 152: the one at 113, or those at 113, 123, 133 and 143, are
        // missed.
        assert_eq!([113, 122, 152].map(|date| timing.since(103, date)), [1, 1, 4]);
    }
}
