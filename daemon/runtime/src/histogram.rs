//! Counters and histograms of durations: one thread writes them without locks, any thread can read
//! them.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Buckets per power of two: a resolution of 12 %.
const STEPS: u64 = 8;
/// Durations above 2^40 ns (18 minutes) share the last bucket.
const BUCKETS: usize = (38 * STEPS) as usize;

/// Histogram of durations in nanoseconds. One thread records, any thread reads.
#[derive(Debug)]
pub(crate) struct Histogram {
    count: AtomicU64,
    sum: AtomicU64,
    last: AtomicU64,
    /// `u64::MAX` before the first.
    min: AtomicU64,
    max: AtomicU64,
    /// Counts, in buckets that grow logarithmically.
    buckets: Box<[AtomicU32]>,
}

/// Summary of measured durations, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Durations {
    /// Number of measurements.
    pub count: u64,
    /// The last measurement.
    pub last_ns: u64,
    /// Mean; 0 when there is no measurement.
    pub mean_ns: u64,
    /// Median.
    pub p50_ns: u64,
    /// 99th percentile.
    pub p99_ns: u64,
    /// Shortest since the start; 0 when there is no measurement.
    pub min_ns: u64,
    /// Longest since the start.
    pub max_ns: u64,
}

/// With a single writer, no atomic read-modify-write is needed.
fn add(cell: &AtomicU64, value: u64) {
    cell.store(cell.load(Ordering::Relaxed).wrapping_add(value), Ordering::Relaxed);
}

impl Default for Histogram {
    fn default() -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            count: zero(),
            sum: zero(),
            last: zero(),
            min: AtomicU64::new(u64::MAX),
            max: zero(),
            buckets: (0..BUCKETS).map(|_| AtomicU32::new(0)).collect(),
        }
    }
}

impl Histogram {
    pub(crate) fn record(&self, ns: u64) {
        add(&self.count, 1);
        add(&self.sum, ns);
        self.last.store(ns, Ordering::Relaxed);
        if ns < self.min.load(Ordering::Relaxed) {
            self.min.store(ns, Ordering::Relaxed);
        }
        if ns > self.max.load(Ordering::Relaxed) {
            self.max.store(ns, Ordering::Relaxed);
        }
        let bucket = &self.buckets[bucket(ns)];
        bucket.store(bucket.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
    }

    /// How many were recorded, and their sum in nanoseconds.
    pub(crate) fn totals(&self) -> (u64, u64) {
        (self.count.load(Ordering::Relaxed), self.sum.load(Ordering::Relaxed))
    }

    /// The buckets that are not empty: the longest duration of each, in nanoseconds, and how many
    /// it has.
    pub(crate) fn buckets(&self) -> Vec<(u64, u64)> {
        let counts = self.buckets.iter().map(|count| u64::from(count.load(Ordering::Relaxed)));
        let all = counts.enumerate().filter(|(_, count)| *count > 0);
        all.map(|(bucket, count)| (upper(bucket), count)).collect()
    }

    pub(crate) fn read(&self) -> Durations {
        let count = self.count.load(Ordering::Relaxed);
        let counts: Vec<u64> =
            self.buckets.iter().map(|b| u64::from(b.load(Ordering::Relaxed))).collect();
        let max = self.max.load(Ordering::Relaxed);
        let total: u64 = counts.iter().sum();
        let quantile = |percent: u64| {
            let rank = (total * percent).div_ceil(100).max(1);
            let mut seen = 0;
            for (bucket, &count) in counts.iter().enumerate() {
                if seen + count >= rank {
                    // The values in a bucket are taken as evenly spread.
                    let lower = bucket.checked_sub(1).map_or(0, |before| upper(before) + 1);
                    let width = upper(bucket) - lower;
                    return (lower + width * (rank - seen) / count).min(max);
                }
                seen += count;
            }
            0
        };
        Durations {
            count,
            last_ns: self.last.load(Ordering::Relaxed),
            mean_ns: self.sum.load(Ordering::Relaxed).checked_div(count).unwrap_or(0),
            p50_ns: quantile(50),
            p99_ns: quantile(99),
            // Recorded after the count: a reader may come between the two.
            min_ns: Some(self.min.load(Ordering::Relaxed)).filter(|ns| *ns < u64::MAX).unwrap_or(0),
            max_ns: max,
        }
    }
}

fn bucket(ns: u64) -> usize {
    if ns < STEPS {
        return ns as usize;
    }
    let power = u64::from(ns.ilog2());
    let step = (ns >> (power - 3)) & (STEPS - 1);
    (((power - 2) * STEPS + step) as usize).min(BUCKETS - 1)
}

/// Longest duration in a bucket, in nanoseconds.
fn upper(bucket: usize) -> u64 {
    let bucket = bucket as u64;
    if bucket < STEPS {
        return bucket;
    }
    let (power, step) = (bucket / STEPS + 2, bucket % STEPS);
    ((STEPS + step + 1) << (power - 3)) - 1
}

/// A counter with a single writer.
#[derive(Debug, Default)]
pub(crate) struct Counter(AtomicU64);

impl Counter {
    pub(crate) fn add(&self, by: u64) {
        add(&self.0, by);
    }

    pub(crate) fn read(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_duration_lies_within_its_bucket() {
        for ns in (0..5000).chain([1 << 20, (1 << 33) + 12345, u64::MAX >> 25]) {
            let at = bucket(ns);
            assert!(ns <= upper(at), "{ns}");
            assert!(at == 0 || ns > upper(at - 1), "{ns}");
        }
    }

    #[test]
    fn quantiles_are_as_near_as_the_buckets_allow() {
        let histogram = Histogram::default();
        (1..=1000).for_each(|ns| histogram.record(ns * 1000));
        let read = histogram.read();
        assert_eq!((read.count, read.last_ns, read.max_ns), (1000, 1_000_000, 1_000_000));
        assert_eq!((read.min_ns, Histogram::default().read().min_ns), (1000, 0));
        assert_eq!(read.mean_ns, 500_500);
        let buckets = histogram.buckets();
        assert_eq!(buckets.iter().map(|(_, count)| count).sum::<u64>(), 1000);
        assert!(buckets.is_sorted() && buckets[0].0 >= 1000, "{buckets:?}");
        assert!((490_000..510_000).contains(&read.p50_ns), "{}", read.p50_ns);
        assert!((980_000..=1_000_000).contains(&read.p99_ns), "{}", read.p99_ns);
    }
}
