//! When a process that ended is started again: back-off, and the greatest number in a window.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use genom_configuration::CellSettings;

/// The restarts of one cell.
#[derive(Debug, Default)]
pub(crate) struct Restarts {
    /// When the last ones were decided, oldest first; only those within the window.
    recent: VecDeque<Instant>,
    /// How often a gateway ended in a row without having run.
    in_vain: i32,
}

impl Restarts {
    /// How long to wait before the next start; `None` when there were too many within the window.
    pub(crate) fn next(&mut self, settings: &CellSettings, now: Instant) -> Option<Duration> {
        while self.recent.front().is_some_and(|&one| now - one >= settings.restart_window) {
            self.recent.pop_front();
        }
        if self.recent.len() >= settings.restart_most {
            return None;
        }
        let before = i32::try_from(self.recent.len()).unwrap_or(i32::MAX);
        self.recent.push_back(now);
        Some(grown(settings, settings.restart_delay, before).min(settings.restart_delay_max))
    }

    /// The same for a gateway, which others need for as long as it takes: it is never given up. One
    /// that ran is back soon, however often it ended. One that did not even start waits longer each
    /// time, so that its starts take no processor.
    pub(crate) fn next_of_gateway(
        &mut self,
        settings: &CellSettings,
        longest: Duration,
        ran: bool,
        now: Instant,
    ) -> Duration {
        if ran {
            self.in_vain = 0;
            return self.next(settings, now).unwrap_or(longest).min(longest);
        }
        let delay = grown(settings, longest, self.in_vain);
        self.in_vain = self.in_vain.saturating_add(1);
        delay.min(settings.restart_delay_max.max(longest))
    }

    /// Somebody asked for a start: what was before counts no more.
    pub(crate) fn forget(&mut self) {
        self.recent.clear();
        self.in_vain = 0;
    }
}

/// A delay after so many ones before it.
fn grown(settings: &CellSettings, delay: Duration, before: i32) -> Duration {
    let delay = delay.as_secs_f64() * settings.restart_factor.powi(before);
    Duration::try_from_secs_f64(delay).unwrap_or(Duration::MAX)
}

/// At most so many things in a second.
#[derive(Debug, Default)]
pub(crate) struct Limit {
    /// When this second began, and how many there were in it.
    second: Option<(Instant, u32)>,
}

impl Limit {
    /// Counts one more.
    ///
    /// # Errors
    /// It is beyond the limit.
    pub(crate) fn allows(&mut self, most: u32, now: Instant) -> Result<(), First> {
        match &mut self.second {
            Some((began, count)) if now.saturating_duration_since(*began) < SECOND => {
                *count = count.saturating_add(1);
                if *count <= most { Ok(()) } else { Err(First(*count == most + 1)) }
            }
            other => {
                *other = Some((now, 1));
                Ok(())
            }
        }
    }
}

const SECOND: Duration = Duration::from_secs(1);

/// Beyond the limit; whether it is the first in this second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct First(pub(crate) bool);

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> CellSettings {
        CellSettings {
            restart_delay: Duration::from_millis(20),
            restart_factor: 4.0,
            restart_delay_max: Duration::from_secs(1),
            restart_most: 4,
            restart_window: Duration::from_secs(60),
            ..CellSettings::default()
        }
    }

    #[test]
    fn each_restart_within_the_window_waits_longer_up_to_the_greatest_delay() {
        let (mut restarts, now) = (Restarts::default(), Instant::now());
        let waits: Vec<_> = (0..4).map(|_| restarts.next(&settings(), now)).collect();
        let ms = |ms| Some(Duration::from_millis(ms));
        assert_eq!(waits, [ms(20), ms(80), ms(320), ms(1000)]);
    }

    #[test]
    fn a_gateway_that_ran_is_back_soon_however_often_it_ended() {
        let (mut restarts, now) = (Restarts::default(), Instant::now());
        let longest = Duration::from_millis(250);
        let waits: Vec<_> = (0..100)
            .map(|_| restarts.next_of_gateway(&settings(), longest, true, now).as_millis())
            .collect();
        assert_eq!(waits[..3], [20, 80, 250]);
        assert!(waits[3..].iter().all(|&wait| wait == 250), "{waits:?}");
    }

    #[test]
    fn a_gateway_that_does_not_start_waits_longer_each_time_until_it_ran() {
        let (mut restarts, now) = (Restarts::default(), Instant::now());
        // Also where cells start again at once.
        let at_once = CellSettings { restart_delay: Duration::ZERO, ..settings() };
        let mut wait = |ran| {
            restarts.next_of_gateway(&at_once, Duration::from_millis(100), ran, now).as_millis()
        };
        assert_eq!([(); 5].map(|()| wait(false)), [100, 400, 1000, 1000, 1000]);
        assert_eq!([wait(true), wait(false), wait(false)], [0, 100, 400]);
    }

    #[test]
    fn a_second_has_so_many_and_the_first_beyond_is_told() {
        let (mut limit, now) = (Limit::default(), Instant::now());
        let told: Vec<_> = (0..4).map(|_| limit.allows(2, now)).collect();
        assert_eq!(told, [Ok(()), Ok(()), Err(First(true)), Err(First(false))]);
        assert_eq!(limit.allows(2, now + Duration::from_millis(999)), Err(First(false)));
        assert_eq!(limit.allows(2, now + SECOND), Ok(()));
    }

    #[test]
    fn too_many_within_the_window_are_the_end_and_later_ones_are_not() {
        let (mut restarts, start) = (Restarts::default(), Instant::now());
        for _ in 0..4 {
            assert!(restarts.next(&settings(), start).is_some());
        }
        assert_eq!(restarts.next(&settings(), start + Duration::from_secs(59)), None);
        let later = start + Duration::from_secs(60);
        assert_eq!(restarts.next(&settings(), later), Some(Duration::from_millis(20)));
    }
}
