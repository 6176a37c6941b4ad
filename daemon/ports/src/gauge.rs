//! What passed through a port or a connection; counted by codels' threads, read by anybody.
//!
//! Rates and bytes are the difference of two readings: exact at any rate, and nothing is asked of
//! the codels' threads.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_protocol::{Counts, Traffic};
use genom_runtime::Clock;
use genom_types::{DataType, Record};

/// Unit of the intervals whose squares are summed, in nanoseconds.
const UNIT: u64 = Traffic::UNIT;

/// Samples of variable size are weighed for so long after somebody asked.
const WEIGHED_FOR: u64 = 5_000_000_000;

/// Counters of one binding.
#[derive(Debug)]
pub struct Gauge {
    /// Samples published, or new ones read.
    samples: AtomicU64,
    /// Samples that middlewares gave up.
    dropped: AtomicU64,
    /// Writes or reads that failed.
    failed: AtomicU64,
    /// Date of the first sample.
    first: AtomicU64,
    /// Date of the last sample.
    last: AtomicU64,
    /// Sum of the squares of the intervals between samples.
    squares: AtomicU64,
    /// Samples of variable size that were weighed, and their bytes.
    weighed: [AtomicU64; 2],
    /// Until when they are weighed: it costs an encoding each.
    weigh_until: AtomicU64,
    /// Bytes of a sample, when all have the same.
    size: Option<u64>,
    /// That of the components: rates are in their time.
    clock: Clock,
}

impl Gauge {
    /// Nothing passed yet.
    pub fn new(clock: &Clock, ty: &DataType) -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            samples: zero(),
            dropped: zero(),
            failed: zero(),
            first: zero(),
            last: zero(),
            squares: zero(),
            weighed: [zero(), zero()],
            weigh_until: zero(),
            size: ty.is_fixed_size().then(|| ty.size() as u64),
            clock: clock.clone(),
        }
    }

    /// A sample passed; `dropped` were given up so far. Called by one thread at a time.
    pub(super) fn passed(&self, dropped: u64) {
        let now = self.clock.now();
        if self.samples.fetch_add(1, Ordering::Relaxed) == 0 {
            self.first.store(now, Ordering::Relaxed);
        } else {
            let interval = now.saturating_sub(self.last.load(Ordering::Relaxed)) / UNIT;
            self.squares.fetch_add(interval.wrapping_mul(interval), Ordering::Relaxed);
        }
        self.dropped.store(dropped, Ordering::Relaxed);
        self.last.store(now, Ordering::Relaxed);
    }

    /// Counts the bytes of a sample, when somebody wants to know and its size varies.
    pub(super) fn weigh(&self, value: &Record, scratch: &mut Vec<u8>) {
        if self.size.is_some() || self.weigh_until.load(Ordering::Relaxed) == 0 {
            return;
        }
        if self.clock.now() > self.weigh_until.load(Ordering::Relaxed) {
            self.weigh_until.store(0, Ordering::Relaxed);
            return;
        }
        scratch.clear();
        if value.encode_cdr(scratch).is_ok() {
            self.weighed[1].fetch_add(scratch.len() as u64, Ordering::Relaxed);
            self.weighed[0].fetch_add(1, Ordering::Relaxed);
        }
    }

    /// So many samples were given up so far, though none passed.
    pub(super) fn lost(&self, dropped: u64) {
        self.dropped.store(dropped, Ordering::Relaxed);
    }

    /// A write or read failed.
    pub(super) fn failed(&self) {
        self.failed.fetch_add(1, Ordering::Relaxed);
    }

    /// Reads all.
    pub fn counts(&self) -> Counts {
        let samples = self.samples.load(Ordering::Relaxed);
        let last = self.last.load(Ordering::Relaxed);
        Counts {
            samples,
            dropped: self.dropped.load(Ordering::Relaxed),
            failed: self.failed.load(Ordering::Relaxed),
            age_ns: (samples > 0).then(|| self.clock.now().saturating_sub(last)),
        }
    }

    /// Reads what rates are made of; from now on, and for a while, samples are weighed.
    pub fn traffic(&self) -> Traffic {
        let now_ns = self.clock.now();
        self.weigh_until.store(now_ns.saturating_add(WEIGHED_FOR), Ordering::Relaxed);
        let counts = self.counts();
        let date = |of: &AtomicU64| (counts.samples > 0).then(|| of.load(Ordering::Relaxed));
        let (weighed, bytes) = match self.size {
            Some(size) => (counts.samples, counts.samples.wrapping_mul(size)),
            None => {
                let [samples, bytes] = &self.weighed;
                (samples.load(Ordering::Relaxed), bytes.load(Ordering::Relaxed))
            }
        };
        let (first_ns, last_ns) = (date(&self.first), date(&self.last));
        let squares = self.squares.load(Ordering::Relaxed);
        Traffic { counts, now_ns, first_ns, last_ns, squares, weighed, bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_runtime::VirtualClock;
    use genom_types::{Kind, TypeTable};
    use std::sync::Arc;
    use std::time::Duration;

    fn of(kind: Kind) -> DataType {
        let mut table = TypeTable::default();
        let id = table.add(kind);
        DataType::new(&Arc::new(table), id).unwrap()
    }

    #[test]
    fn intervals_are_those_of_the_components_clock() {
        let time = Arc::new(VirtualClock::new());
        let gauge = Gauge::new(&Clock::Virtual(Arc::clone(&time)), &of(Kind::Double));
        assert_eq!(gauge.traffic().last_ns, None);
        for milliseconds in [0, 10, 20] {
            time.step(Duration::from_millis(milliseconds));
            gauge.passed(0);
        }
        let traffic = gauge.traffic();
        assert_eq!((traffic.first_ns, traffic.last_ns), (Some(0), Some(30_000_000)));
        assert_eq!(traffic.squares, 100_000_u64.pow(2) + 200_000_u64.pow(2));
        assert_eq!((traffic.weighed, traffic.bytes), (3, 24));
    }

    #[test]
    fn samples_of_variable_size_are_weighed_while_somebody_asks() {
        let time = Arc::new(VirtualClock::new());
        let ty = of(Kind::String { bound: None });
        let gauge = Gauge::new(&Clock::Virtual(Arc::clone(&time)), &ty);
        let (mut value, mut scratch) = (Record::new(&ty), Vec::new());
        value.merge_json(&"four".into()).unwrap();
        gauge.weigh(&value, &mut scratch);
        assert_eq!(gauge.traffic().bytes, 0);
        gauge.weigh(&value, &mut scratch);
        let first = gauge.traffic();
        assert_eq!(first.weighed, 1);
        // The length, the text and its end.
        assert_eq!(first.bytes, 4 + 5);
        time.step(Duration::from_nanos(WEIGHED_FOR + 1));
        gauge.weigh(&value, &mut scratch);
        assert_eq!(gauge.traffic().bytes, first.bytes);
    }
}
