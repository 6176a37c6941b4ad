//! Averages of a task over about the last ten seconds (genom3.md 4.8, 7.8).
//!
//! It does not depend on clocks, tasks or ports: the caller passes dates and totals since the
//! start, and the window keeps one pair per second.

use std::collections::VecDeque;

/// Length of the window, in nanoseconds.
const SPAN_NS: u64 = 10_000_000_000;
/// Time between two totals that are kept, in nanoseconds.
const STEP_NS: u64 = 1_000_000_000;

/// Totals of a task since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Totals {
    /// Date of these totals, in nanoseconds.
    pub(crate) date: u64,
    /// Number of cycles.
    pub(crate) cycles: u64,
    /// Total duration of the cycles, in nanoseconds.
    pub(crate) busy_ns: u64,
}

/// Totals of the last ten seconds, one per second, and the maximum load since the start.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// Oldest first; the first one is as old as the window is long, once there is one that old.
    kept: VecDeque<Totals>,
    /// Load between the last two totals kept, in percent.
    last_load: f64,
    max_load: f64,
}

/// Averages over about the last ten seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Recent {
    /// Mean duration of a cycle, in nanoseconds.
    pub(crate) mean_ns: f64,
    /// Share of the time in cycles, in percent.
    pub(crate) load: f64,
    /// Load over the last second, and its maximum since the start, in percent.
    pub(crate) last_load: f64,
    pub(crate) max_load: f64,
}

impl Window {
    /// Adds totals and returns the averages.
    pub(crate) fn look(&mut self, now: Totals) -> Recent {
        match self.kept.back() {
            Some(last) if now.date < last.date.saturating_add(STEP_NS) => {}
            last => {
                if let Some(last) = last {
                    self.last_load = load(*last, now);
                    self.max_load = self.max_load.max(self.last_load);
                }
                self.kept.push_back(now);
            }
        }
        // One total older than the window is kept, so that the difference covers all of it.
        while self.kept.get(1).is_some_and(|next| next.date.saturating_add(SPAN_NS) <= now.date) {
            self.kept.pop_front();
        }
        let since = self.kept.front().copied().unwrap_or(now);
        Recent {
            mean_ns: mean(since, now),
            load: load(since, now),
            last_load: self.last_load,
            max_load: self.max_load,
        }
    }
}

#[allow(clippy::cast_precision_loss)]
fn mean(since: Totals, now: Totals) -> f64 {
    match now.cycles.wrapping_sub(since.cycles) {
        // No cycle ended: the time in the one under way.
        0 => now.busy_ns.wrapping_sub(since.busy_ns) as f64,
        cycles => now.busy_ns.wrapping_sub(since.busy_ns) as f64 / cycles as f64,
    }
}

#[allow(clippy::cast_precision_loss)]
fn load(since: Totals, now: Totals) -> f64 {
    match now.date.saturating_sub(since.date) {
        0 => 0.0,
        // The date of a total may differ a little from the dates of the cycles in it.
        span => (now.busy_ns.wrapping_sub(since.busy_ns) as f64 * 100.0 / span as f64).min(100.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    /// Averages of a task with a hundred cycles of `busy` nanoseconds in each second.
    fn lived(busy: &[u64]) -> Recent {
        let mut window = Window::default();
        let mut now = Totals::default();
        let mut recent = window.look(now);
        for busy in busy {
            now.date += SECOND;
            now.cycles += 100;
            now.busy_ns += 100 * busy;
            recent = window.look(now);
        }
        recent
    }

    #[test]
    fn an_average_reaches_ten_seconds_back_and_no_further() {
        // genom3.md 4.8, 7.8: averages over ~10 s.
        let long_ago = vec![5_000_000; 60];
        let recent = lived(&[long_ago.clone(), vec![1_000_000; 10]].concat());
        assert_eq!((recent.mean_ns, recent.load), (1_000_000.0, 10.0));
        assert_eq!((recent.last_load, recent.max_load), (10.0, 50.0));
        // Five of the ten seconds had long cycles.
        let recent = lived(&[long_ago, vec![1_000_000; 5]].concat());
        assert_eq!((recent.mean_ns, recent.load), (3_000_000.0, 30.0));
    }

    #[test]
    fn a_young_task_is_averaged_since_its_start() {
        assert_eq!(lived(&[]), Recent::default());
        let recent = lived(&[2_000_000, 4_000_000]);
        assert_eq!((recent.mean_ns, recent.load), (3_000_000.0, 30.0));
    }

    #[test]
    fn looking_often_neither_shortens_the_window_nor_grows_it() {
        let mut window = Window::default();
        let mut now = Totals::default();
        for _ in 0..100_000 {
            now.date += SECOND / 1000;
            now.cycles += 1;
            now.busy_ns += 300_000;
            window.look(now);
        }
        assert!(window.kept.len() <= 12, "{}", window.kept.len());
        let recent = window.look(now);
        assert!((recent.mean_ns - 300_000.0).abs() < 1.0 && (recent.load - 30.0).abs() < 0.1);
    }

    #[test]
    fn a_cycle_that_lasts_loads_as_long_as_it_does_and_not_beyond_the_window() {
        let mut window = Window::default();
        window.look(Totals::default());
        window.look(Totals { date: 20 * SECOND, cycles: 0, busy_ns: 0 });
        let recent = window.look(Totals { date: 21 * SECOND, cycles: 1, busy_ns: 15 * SECOND });
        assert!(recent.last_load <= 100.0 && recent.load <= 100.0, "{recent:?}");
        // No cycle ended in the last second; the time in the one under way counts all the same.
        let mut window = Window::default();
        for second in 0..20 {
            let busy_ns = second * 850_000_000;
            window.look(Totals { date: second * SECOND, cycles: 1, busy_ns });
        }
        let recent = window.look(Totals { date: 20 * SECOND, cycles: 1, busy_ns: 17 * SECOND });
        assert!((recent.load - 85.0).abs() < 0.1 && (recent.last_load - 85.0).abs() < 0.1);
        assert!((recent.mean_ns - 8.5e9).abs() < 1.0, "{recent:?}");
    }
}
