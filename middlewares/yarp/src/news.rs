//! Lines of the log about connections. Whoever reaches a port decides how many there are to tell of,
//! so their number is limited.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Lines that may be written at once, after a while without any.
const MOST: u32 = 64;

/// Time after which one more may be written.
const BETWEEN: Duration = Duration::from_secs(1);

/// Limits the lines.
#[derive(Debug, Default)]
pub(crate) struct News(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    /// Lines that were written and do not count as a while ago yet, at this time.
    written: u32,
    at: Option<Instant>,
    left_out: u64,
}

impl News {
    /// Has a line written, unless there were too many. The next one tells how many were left out.
    pub(crate) fn tell(&self, line: impl FnOnce()) {
        let Some(left_out) = self.line_at(Instant::now()) else { return };
        if left_out > 0 {
            tracing::info!(left_out, "more YARP connections came and went");
        }
        line();
    }

    /// The number of those that were left out, if a line may be written.
    fn line_at(&self, now: Instant) -> Option<u64> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = *state.at.get_or_insert(now);
        let passed = now.saturating_duration_since(at).as_secs() / BETWEEN.as_secs();
        let passed = u32::try_from(passed).unwrap_or(u32::MAX);
        state.written = state.written.saturating_sub(passed);
        state.at = Some(at + BETWEEN * passed);
        if state.written >= MOST {
            state.left_out += 1;
            return None;
        }
        state.written += 1;
        Some(std::mem::take(&mut state.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_lines_may_come_at_once_and_later_one_a_second() {
        let (news, start) = (News::default(), Instant::now());
        let told = |milliseconds| news.line_at(start + Duration::from_millis(milliseconds));
        let at_once: Vec<_> = (0..100).filter_map(|_| told(0)).collect();
        assert_eq!(at_once, [0; MOST as usize]);
        assert_eq!((told(999), told(1000), told(1001)), (None, Some(37), None));
        let flood: Vec<u64> = (1002..11_000).filter_map(told).collect();
        assert_eq!(flood, [999, 999, 999, 999, 999, 999, 999, 999, 999]);
        // After a while without any, as many as at first.
        let later = 11_000 + 1000 * u64::from(MOST);
        assert_eq!((0..100).filter_map(|_| told(later)).count(), MOST as usize);
    }
}
