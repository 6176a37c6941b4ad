//! Ticks that a task missed within a window that slides.

use std::collections::VecDeque;

use genom_description::model::TaskIx;

/// The window of one rule.
#[derive(Debug)]
pub(super) struct Window {
    pub(super) rule: usize,
    pub(super) task: TaskIx,
    /// So many within the window break the rule.
    pub(super) ticks: u64,
    /// Length in nanoseconds.
    pub(super) within: u64,
    /// Ticks missed since the start, when it was last looked at.
    total: u64,
    /// When ticks were seen to be missed, and how many; fewer entries than `ticks`.
    recent: VecDeque<(u64, u64)>,
}

impl Window {
    pub(super) fn new(rule: usize, task: TaskIx, ticks: u64, within: u64) -> Self {
        Self { rule, task, ticks, within, total: 0, recent: VecDeque::new() }
    }

    /// Takes in the ticks missed until now. Returns the number within the window if the rule is
    /// broken; after that it counts from zero.
    pub(super) fn look(&mut self, total: u64, now: u64) -> Option<u64> {
        while self.recent.front().is_some_and(|(date, _)| date.saturating_add(self.within) < now) {
            self.recent.pop_front();
        }
        let new = total.saturating_sub(self.total);
        if new == 0 {
            return None;
        }
        self.total = total;
        self.recent.push_back((now, new));
        let within = self.sum();
        (within >= self.ticks).then(|| {
            self.recent.clear();
            within
        })
    }

    /// Ticks that may still be missed within the window.
    pub(super) fn left(&self) -> u64 {
        self.ticks.saturating_sub(self.sum()).max(1)
    }

    fn sum(&self) -> u64 {
        self.recent.iter().map(|(_, ticks)| ticks).sum()
    }
}

#[cfg(test)]
mod tests {
    use genom_description::model::Ix as _;

    use super::*;

    #[test]
    fn so_many_ticks_within_the_window_break_the_rule_and_then_it_counts_anew() {
        let mut window = Window::new(0, TaskIx::new(0), 3, 100);
        assert_eq!(window.look(0, 5), None);
        assert_eq!(window.look(2, 10), None);
        assert_eq!(window.left(), 1);
        // Those of date 10 are out of the window at 111, and in it at 110.
        assert_eq!(window.look(3, 111), None);
        assert_eq!(window.look(4, 150), None);
        assert_eq!(window.look(5, 210), Some(3));
        assert_eq!(window.look(7, 211), None);
        assert_eq!(window.look(7, 212), None);
        assert_eq!(window.look(9, 213), Some(4));
    }

    #[test]
    fn many_ticks_at_once_break_the_rule_once_and_take_no_room() {
        let mut window = Window::new(0, TaskIx::new(0), 1000, u64::MAX);
        assert_eq!(window.look(1_000_000, 1), Some(1_000_000));
        for total in 0..10_000 {
            window.look(1_000_000 + total, total);
            assert!(window.recent.len() < 1000);
        }
    }
}
