//! Cycles of a task: a cycle lasts from a tick, or from a wake-up, until there is nothing left to
//! do. Any thread may read the figures, also during a cycle.
//!
//! The task writes them with a few stores per cycle, under a sequence lock: the version is odd
//! while it writes, and a reader that sees an odd or changed version reads again.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};
use std::time::Duration;

use genom_description::model::{CodelIx, Ix as _};

use crate::histogram::{Durations, Histogram};

/// In place of a date when no cycle is under way.
const NONE: u64 = u64::MAX;
/// How often a reader retries: the task may have been preempted between its stores.
const TRIES: usize = 4000;
/// Retries before the first pause.
const AT_ONCE: usize = 100;
/// Pause between later retries.
const REST: Duration = Duration::from_micros(50);

/// Figures of completed cycles, and the one under way.
#[derive(Debug)]
pub(crate) struct Cycles {
    /// Odd while the task changes the fields below.
    version: AtomicU64,
    over: Histogram,
    began: AtomicU64,
    /// Date at which the last one began, also once it is over.
    last: AtomicU64,
    /// How often a codel of this cycle yielded a state without pause.
    steps: AtomicU64,
    /// The last codel that did.
    codel: AtomicU32,
}

/// A cycle under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lasting {
    /// Date of its begin, in nanoseconds.
    pub(crate) began: u64,
    /// Duration so far, in nanoseconds.
    pub(crate) for_ns: u64,
    /// How often a codel yielded a state without pause.
    pub(crate) steps: u64,
    /// The last codel that did.
    pub(crate) codel: CodelIx,
}

/// Totals up to a date, including the cycle under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Total {
    pub(crate) cycles: u64,
    pub(crate) busy_ns: u64,
}

impl Default for Cycles {
    fn default() -> Self {
        Self {
            version: AtomicU64::new(0),
            over: Histogram::default(),
            began: AtomicU64::new(NONE),
            last: AtomicU64::new(0),
            steps: AtomicU64::new(0),
            codel: AtomicU32::new(0),
        }
    }
}

impl Cycles {
    /// A cycle begins at this date.
    #[inline]
    pub(crate) fn begins(&self, date: u64) {
        self.change(|| {
            self.began.store(date, Ordering::Relaxed);
            self.last.store(date, Ordering::Relaxed);
            self.steps.store(0, Ordering::Relaxed);
        });
    }

    /// When the last cycle began; 0 before the first.
    pub(crate) fn last(&self) -> u64 {
        self.last.load(Ordering::Relaxed)
    }

    /// The cycle ends at this date.
    #[inline]
    pub(crate) fn ends(&self, date: u64) {
        self.change(|| {
            let began = self.began.load(Ordering::Relaxed);
            self.began.store(NONE, Ordering::Relaxed);
            if began != NONE {
                self.over.record(date.saturating_sub(began));
            }
        });
    }

    /// A codel of the cycle yielded a state without pause.
    #[inline]
    pub(crate) fn goes_on(&self, codel: CodelIx) {
        self.codel.store(u32::try_from(codel.index()).unwrap_or(u32::MAX), Ordering::Relaxed);
        self.steps.store(self.steps.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    fn change(&self, work: impl FnOnce()) {
        let version = self.version.load(Ordering::Relaxed);
        self.version.store(version.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        work();
        self.version.store(version.wrapping_add(2), Ordering::Release);
    }

    fn consistent<T>(&self, mut read: impl FnMut() -> T) -> T {
        for tried in 0..TRIES {
            let before = self.version.load(Ordering::Acquire);
            let found = read();
            fence(Ordering::Acquire);
            if before.is_multiple_of(2) && before == self.version.load(Ordering::Relaxed) {
                return found;
            }
            match tried {
                0..AT_ONCE => std::hint::spin_loop(),
                _ => std::thread::park_timeout(REST),
            }
        }
        read()
    }

    /// The cycle under way at this date, if there is one.
    pub(crate) fn lasting(&self, now: u64) -> Option<Lasting> {
        self.consistent(|| {
            let began = self.began.load(Ordering::Relaxed);
            (began != NONE).then(|| Lasting {
                began,
                for_ns: now.saturating_sub(began),
                steps: self.steps.load(Ordering::Relaxed),
                codel: CodelIx::new(self.codel.load(Ordering::Relaxed) as usize),
            })
        })
    }

    /// Number of cycles until this date, and their total duration.
    pub(crate) fn total(&self, now: u64) -> Total {
        self.consistent(|| {
            let (cycles, busy_ns) = self.over.totals();
            match self.began.load(Ordering::Relaxed) {
                NONE => Total { cycles, busy_ns },
                began => Total {
                    cycles: cycles + 1,
                    busy_ns: busy_ns.saturating_add(now.saturating_sub(began)),
                },
            }
        })
    }

    /// The buckets of completed cycles that are not empty.
    pub(crate) fn buckets(&self) -> Vec<(u64, u64)> {
        self.over.buckets()
    }

    /// Figures at this date. Quantiles and the last duration are those of completed cycles, if
    /// there are any.
    pub(crate) fn read(&self, now: u64) -> Durations {
        let (mut figures, total, lasting) =
            self.consistent(|| (self.over.read(), self.total(now), self.lasting(now)));
        let Some(Lasting { for_ns, .. }) = lasting else { return figures };
        if figures.count == 0 {
            figures.last_ns = for_ns;
            figures.p50_ns = for_ns;
            figures.p99_ns = for_ns;
            figures.min_ns = for_ns;
        }
        figures.count = total.cycles;
        figures.mean_ns = total.busy_ns.checked_div(total.cycles).unwrap_or_default();
        figures.max_ns = figures.max_ns.max(for_ns);
        figures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn a_cycle_counts_from_its_begin_and_only_once() {
        let cycles = Cycles::default();
        assert_eq!(cycles.read(50), Durations::default());
        cycles.begins(100);
        assert_eq!(cycles.total(130), Total { cycles: 1, busy_ns: 30 });
        let figures = cycles.read(130);
        assert_eq!(
            (figures.count, figures.mean_ns, figures.max_ns, figures.p50_ns),
            (1, 30, 30, 30)
        );
        cycles.goes_on(CodelIx::new(7));
        cycles.goes_on(CodelIx::new(8));
        let lasting = cycles.lasting(140).unwrap();
        assert_eq!((lasting.for_ns, lasting.steps, lasting.codel.index()), (40, 2, 8));
        cycles.ends(150);
        assert_eq!(cycles.total(990), Total { cycles: 1, busy_ns: 50 });
        assert_eq!(cycles.lasting(990), None);
        cycles.begins(1000);
        assert_eq!(cycles.lasting(1000).unwrap().steps, 0);
        let figures = cycles.read(1010);
        assert_eq!((figures.count, figures.mean_ns), (2, 30));
        assert_eq!((figures.last_ns, figures.min_ns, figures.max_ns), (50, 50, 50));
    }

    #[test]
    fn whoever_reads_beside_the_task_never_sees_time_go_back() {
        let (cycles, over) = (Cycles::default(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for date in 0..200_000 {
                    cycles.begins(date * 10);
                    cycles.ends(date * 10 + 10);
                }
                over.store(true, Ordering::Release);
            });
            let mut last = Total::default();
            while !over.load(Ordering::Acquire) {
                // A date before the cycle's begin adds no time.
                let total = cycles.total(0);
                assert!(total.cycles >= last.cycles && total.busy_ns >= last.busy_ns, "{total:?}");
                assert!(total.busy_ns.abs_diff(total.cycles * 10) <= 10, "{total:?}");
                last = total;
            }
        });
        assert_eq!(cycles.total(0), Total { cycles: 200_000, busy_ns: 2_000_000 });
    }
}
