//! Dates of a task's ticks (genom3.md 7.4).

/// A periodic task's ticks: `epoch + delay + n * period`.
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

    /// The first tick after this date.
    pub(crate) fn after(&self, date: u64) -> u64 {
        match date.checked_sub(self.base) {
            Some(since) => self.base + (since / self.period + 1) * self.period,
            None => self.base,
        }
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
}
