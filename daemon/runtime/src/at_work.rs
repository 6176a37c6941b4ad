//! The codel that a context runs, and the date of its call. The thread that calls codels writes it;
//! any thread may read it.
//!
//! A call costs two stores: the date was already read for the statistics.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use genom_description::model::{CodelIx, Ix as _};

/// The codel that one context runs.
#[derive(Debug, Default)]
pub(crate) struct AtWork {
    /// Index of the codel plus one; 0 between codels.
    codel: AtomicU32,
    /// Monotonic date of its call, in nanoseconds.
    since: AtomicU64,
}

impl AtWork {
    /// Records that a codel is called at this date.
    #[inline]
    pub(crate) fn begins(&self, codel: CodelIx, date: u64) {
        // The date first: a reader that sees the codel must not see the date of an earlier call.
        self.since.store(date, Ordering::Relaxed);
        let number = u32::try_from(codel.index() + 1).unwrap_or(u32::MAX);
        self.codel.store(number, Ordering::Release);
    }

    /// Records that it returned.
    #[inline]
    pub(crate) fn ends(&self) {
        self.codel.store(0, Ordering::Release);
    }

    /// The running codel, and the date of its call.
    pub(crate) fn look(&self) -> Option<(CodelIx, u64)> {
        let codel = (self.codel.load(Ordering::Acquire) as usize).checked_sub(1)?;
        Some((CodelIx::new(codel), self.since.load(Ordering::Relaxed)))
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
        at_work.begins(codel, 7);
        assert_eq!(at_work.look(), Some((codel, 7)));
        at_work.ends();
        assert_eq!(at_work.look(), None);
    }
}
