//! Counters of the samples that passed through a port or a connection. The threads of codels update
//! them; any thread may read them.
//!
//! Rates are differences between two readings: they are exact at any rate, and reading does not
//! involve the codels' threads.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_protocol::{Counts, Traffic};
use genom_runtime::Clock;
use genom_types::{DataType, Record};

/// Unit of the intervals whose squares are summed, in nanoseconds.
const UNIT: u64 = Traffic::UNIT;

/// After [`Gauge::traffic`], samples of variable size are measured for this long, in nanoseconds.
const WEIGHED_FOR: u64 = 5_000_000_000;

/// Counters of one port, or of one element of a multiple port.
#[derive(Debug)]
pub struct Gauge {
    /// Samples published, or new ones read.
    samples: AtomicU64,
    /// Samples that middlewares dropped.
    dropped: AtomicU64,
    /// Writes or reads that failed.
    failed: AtomicU64,
    /// Date of the first sample, in nanoseconds of the components' clock.
    first: AtomicU64,
    /// Date of the last sample, likewise.
    last: AtomicU64,
    /// Sum of the squares of the intervals between samples, in units of `UNIT`², wrapping.
    squares: AtomicU64,
    /// For samples of variable size: how many were measured, and their total size in bytes.
    weighed: [AtomicU64; 2],
    /// Date until which samples are measured, 0 when they are not: measuring one costs an encoding.
    weigh_until: AtomicU64,
    /// Size of a sample in bytes; `None` if it varies.
    size: Option<u64>,
    /// The clock of the components: rates are in its time.
    clock: Clock,
}

impl Gauge {
    /// Counters at zero, for samples of type `ty`.
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

    /// Counts a sample; `dropped` is the total dropped so far. To be called by one thread at a
    /// time.
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

    /// Measures the encoded size of a sample, if sizes vary and `traffic` was called recently.
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

    /// Sets the total of dropped samples, without counting a new sample.
    pub(super) fn lost(&self, dropped: u64) {
        self.dropped.store(dropped, Ordering::Relaxed);
    }

    /// Counts a failed write or read.
    pub(super) fn failed(&self) {
        self.failed.fetch_add(1, Ordering::Relaxed);
    }

    /// Reads the counters.
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

    /// Reads the counters that rates are computed from. From now on, and for five seconds, samples
    /// of variable size are measured.
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
        // CDR of a string: a length of 4 bytes, the text, a NUL.
        assert_eq!(first.bytes, 4 + 5);
        time.step(Duration::from_nanos(WEIGHED_FOR + 1));
        gauge.weigh(&value, &mut scratch);
        assert_eq!(gauge.traffic().bytes, first.bytes);
    }
}
