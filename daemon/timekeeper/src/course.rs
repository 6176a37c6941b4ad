//! What the dates that a simulator publishes mean for the clock of the components.

use std::time::Duration;

/// A longer way from one date to the next is a jump, not time that passed: components would have to
/// run all ticks in between at once.
pub(crate) const LONGEST: Duration = Duration::from_secs(10);

/// What to do about a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Move {
    /// The first date. Components go on from here.
    Begin,
    /// So much time has passed.
    Step(Duration),
    /// The date is the one before: the simulator stands still.
    Stay,
    /// The simulator was set back, by so much. Time of components stands still for this one, and
    /// goes on from here.
    Back(Duration),
    /// The simulator jumped ahead, by more than 10 s. As for [`Back`](Self::Back).
    Ahead(Duration),
}

/// The date that was seen last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Course(Option<Duration>);

impl Course {
    /// What a date means after those before it.
    pub(crate) fn at(&mut self, date: Duration) -> Move {
        let Some(before) = self.0.replace(date) else { return Move::Begin };
        match date.checked_sub(before) {
            None => Move::Back(before - date),
            Some(Duration::ZERO) => Move::Stay,
            Some(passed) if passed > LONGEST => Move::Ahead(passed),
            Some(passed) => Move::Step(passed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(number: u64) -> Duration {
        Duration::from_millis(number)
    }

    #[test]
    fn time_passes_from_one_date_to_the_next() {
        let mut course = Course::default();
        assert_eq!(course.at(ms(1_700_000_000_000)), Move::Begin);
        assert_eq!(course.at(ms(1_700_000_000_010)), Move::Step(ms(10)));
        assert_eq!(course.at(ms(1_700_000_000_010)), Move::Stay);
        assert_eq!(course.at(ms(1_700_000_000_011)), Move::Step(ms(1)));
    }

    #[test]
    fn after_a_jump_time_goes_on_from_there() {
        let mut course = Course::default();
        course.at(ms(5000));
        // A simulation that was started again.
        assert_eq!(course.at(ms(0)), Move::Back(ms(5000)));
        assert_eq!(course.at(ms(1)), Move::Step(ms(1)));
        assert_eq!(course.at(ms(10_001)), Move::Step(LONGEST));
        assert_eq!(course.at(ms(20_002)), Move::Ahead(ms(10_001)));
        assert_eq!(course.at(ms(20_003)), Move::Step(ms(1)));
    }
}
