//! The codel that a context runs, and the date of its call. The thread that calls codels writes it;
//! any thread may read it.
//!
//! A call costs two stores: the date was already read for the statistics.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_description::model::{CodelIx, Ix as _};

/// The codel that one context runs.
#[derive(Debug, Default)]
pub(crate) struct AtWork {
    /// Index of the codel plus one, and above 32 bits the activity; 0 between codels.
    codel: AtomicU64,
    /// Monotonic date of its call, in nanoseconds.
    since: AtomicU64,
}

impl AtWork {
    /// Records that a codel is called at this date by an activity; 0 if it is of a request.
    #[inline]
    pub(crate) fn begins(&self, codel: CodelIx, activity: u32, date: u64) {
        // The date first: a reader that sees the codel must not see the date of an earlier call.
        self.since.store(date, Ordering::Relaxed);
        let number = u32::try_from(codel.index() + 1).unwrap_or(u32::MAX);
        self.codel.store(u64::from(number) | u64::from(activity) << 32, Ordering::Release);
    }

    /// Records that it returned.
    #[inline]
    pub(crate) fn ends(&self) {
        self.codel.store(0, Ordering::Release);
    }

    /// The running codel, its activity, and the date of its call.
    pub(crate) fn look(&self) -> Option<(CodelIx, u32, u64)> {
        let both = self.codel.load(Ordering::Acquire);
        let [codel, activity] = [both as u32, (both >> 32) as u32];
        let codel = CodelIx::new((codel as usize).checked_sub(1)?);
        Some((codel, activity, self.since.load(Ordering::Relaxed)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_codel_shows_from_its_call_to_its_return() {
        let at_work = AtWork::default();
        assert_eq!(at_work.look(), None);
        let codel = CodelIx::new(0);
        at_work.begins(codel, 3, 7);
        assert_eq!(at_work.look(), Some((codel, 3, 7)));
        at_work.ends();
        assert_eq!(at_work.look(), None);
    }
}
