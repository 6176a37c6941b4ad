//! What passed through a port or a connection; counted by codels' threads, read by anybody.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Counters of one binding.
#[derive(Debug)]
pub(crate) struct Gauge {
    /// Samples published, or new ones read.
    samples: AtomicU64,
    /// Samples that middlewares gave up.
    dropped: AtomicU64,
    /// Writes or reads that failed.
    failed: AtomicU64,
    /// Nanoseconds from `made` to the last sample; 0 before the first.
    last: AtomicU64,
    made: Instant,
}

/// A gauge as read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Counts {
    /// Samples published, or new ones read.
    pub(crate) samples: u64,
    /// Samples that middlewares gave up.
    pub(crate) dropped: u64,
    /// Writes or reads that failed.
    pub(crate) failed: u64,
    /// Age of the last sample, in nanoseconds.
    pub(crate) age_ns: Option<u64>,
}

impl Gauge {
    pub(crate) fn new() -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            samples: zero(),
            dropped: zero(),
            failed: zero(),
            last: zero(),
            made: Instant::now(),
        }
    }

    /// A sample passed; `dropped` were given up so far.
    pub(super) fn passed(&self, dropped: u64) {
        self.samples.fetch_add(1, Ordering::Relaxed);
        self.dropped.store(dropped, Ordering::Relaxed);
        self.last.store(self.now().max(1), Ordering::Relaxed);
    }

    /// A write or read failed.
    pub(super) fn failed(&self) {
        self.failed.fetch_add(1, Ordering::Relaxed);
    }

    /// Reads all.
    pub(crate) fn counts(&self) -> Counts {
        let last = self.last.load(Ordering::Relaxed);
        Counts {
            samples: self.samples.load(Ordering::Relaxed),
            dropped: self.dropped.load(Ordering::Relaxed),
            failed: self.failed.load(Ordering::Relaxed),
            age_ns: (last > 0).then(|| self.now().saturating_sub(last)),
        }
    }

    fn now(&self) -> u64 {
        u64::try_from(self.made.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}
