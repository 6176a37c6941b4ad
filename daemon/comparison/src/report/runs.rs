//! The runs of a way, and what they found together.

use std::time::Duration;

use genom_protocol::{Policy, Traffic};

use super::{ConnectionReport, Recorded, WayReport};
use crate::figures::Figures;
use crate::pairing::Pairs;

/// One run of a way.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Processor time taken while counters were measured.
    pub processor: Duration,
    /// How long they were.
    pub span: Duration,
    /// Memory in bytes.
    pub memory: u64,
    /// Number of processes.
    pub processes: usize,
    /// Its connections.
    pub connections: Vec<Measured>,
}

/// One connection in a run.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The in port.
    pub inport: String,
    /// The out port.
    pub outport: String,
    /// The middleware.
    pub backend: String,
    /// Which unread samples are kept.
    pub policy: Policy,
    /// Counters of the out port before and after; none if it is elsewhere.
    pub out: Option<[Traffic; 2]>,
    /// Counters of the in port before and after.
    pub into: [Traffic; 2],
    /// Its samples.
    pub pairs: Pairs,
}

/// The runs of a way so far.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    way: String,
    error: Option<String>,
    all: Vec<Run>,
}

impl Runs {
    /// None yet.
    #[must_use]
    pub fn of(way: &str) -> Self {
        Self { way: way.to_owned(), ..Self::default() }
    }

    /// Another run, or why there is none.
    pub fn add(&mut self, run: Result<Run, String>) {
        match run {
            Ok(run) => self.all.push(run),
            Err(why) => self.error = Some(why),
        }
    }

    /// What all runs found together: sums of counts, and percentiles of all samples.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
    pub fn report(self) -> WayReport {
        let Self { way, error, all } = self;
        let mut report = WayReport { way, error, ..WayReport::default() };
        let seconds: f64 = all.iter().map(|run| run.span.as_secs_f64()).sum();
        let processor: f64 = all.iter().map(|run| run.processor.as_secs_f64()).sum();
        report.cpu_percent = (seconds > 0.0).then(|| processor / seconds * 100.0);
        report.memory_bytes = all.iter().map(|run| run.memory).max();
        report.processes = all.iter().map(|run| run.processes).max();
        let names = all.iter().flat_map(|run| &run.connections).map(|one| one.inport.clone());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names.dedup();
        report.connections = names
            .iter()
            .filter_map(|name| {
                let of =
                    |run: &Run| run.connections.iter().find(|one| one.inport == *name).cloned();
                together(all.iter().filter_map(of).collect(), seconds)
            })
            .collect();
        report
    }
}

/// Difference of a counter between two readings.
fn gained([before, after]: &[Traffic; 2], of: impl Fn(&Traffic) -> u64) -> u64 {
    of(after).saturating_sub(of(before))
}

#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
fn together(runs: Vec<Measured>, seconds: f64) -> Option<ConnectionReport> {
    let first = runs.first()?.clone();
    let (mut pairs, mut weighed, mut bytes) = (Pairs::default(), 0, 0);
    let mut told = ConnectionReport {
        inport: first.inport,
        outport: first.outport,
        backend: first.backend,
        policy: first.policy.to_string(),
        written: first.out.map(|_| 0),
        ..ConnectionReport::default()
    };
    for run in runs {
        let into = run.into;
        told.read += gained(&into, |one| one.counts.samples);
        told.dropped_by_reader += gained(&into, |one| one.counts.dropped);
        told.failed += gained(&into, |one| one.counts.failed);
        let mut sizes = into;
        if let Some(out) = run.out {
            let written = gained(&out, |one| one.counts.samples);
            told.written = told.written.map(|sum| sum + written);
            told.dropped_by_writer += gained(&out, |one| one.counts.dropped);
            told.failed += gained(&out, |one| one.counts.failed);
            sizes = out;
        }
        weighed += gained(&sizes, |one| one.weighed);
        bytes += sizes[1].bytes.wrapping_sub(sizes[0].bytes);
        pairs.add(run.pairs);
    }
    let rate = |count: u64| if seconds > 0.0 { count as f64 / seconds } else { 0.0 };
    told.written_hz = told.written.map(rate);
    told.read_hz = rate(told.read);
    told.sample_bytes = (weighed > 0).then(|| bytes as f64 / weighed as f64);
    let Pairs { latencies, hops, sent, skipped, alike, unknown } = pairs;
    let received = latencies.len() as u64;
    told.recorded = Recorded { sent, received, skipped, alike, unknown };
    told.latency_us = Figures::of(latencies);
    told.hop_us = Figures::of(hops);
    Some(told)
}

#[cfg(test)]
pub(crate) mod tests {
    use genom_protocol::Counts;

    use super::*;
    use crate::floor::Load;
    use crate::report::tests::report;

    fn traffic(samples: u64, dropped: u64, size: u64) -> Traffic {
        let counts = Counts { samples, dropped, ..Counts::default() };
        Traffic { counts, weighed: samples, bytes: samples * size, ..Traffic::default() }
    }

    pub(crate) fn run(hops: &[u64]) -> Run {
        let pairs = Pairs {
            latencies: hops.iter().map(|hop| hop + 1_000_000).collect(),
            hops: hops.to_vec(),
            sent: hops.len() as u64 + 1,
            skipped: 1,
            ..Pairs::default()
        };
        let one = Measured {
            inport: "viewer/image".to_owned(),
            outport: "camera/image".to_owned(),
            backend: "shm".to_owned(),
            policy: Policy::Latest,
            out: Some([traffic(100, 0, 16), traffic(400, 2, 16)]),
            into: [traffic(100, 0, 16), traffic(390, 3, 16)],
            pairs,
        };
        Run {
            processor: Duration::from_millis(500),
            span: Duration::from_secs(10),
            memory: 30_000_000,
            processes: 2,
            connections: vec![one],
        }
    }

    #[test]
    fn runs_of_a_way_are_summed() {
        let report = report();
        let shm = &report.ways[0];
        assert_eq!((shm.cpu_percent, shm.memory_bytes), (Some(5.0), Some(30_000_000)));
        let one = &shm.connections[0];
        assert_eq!((one.written, one.read, one.dropped()), (Some(600), 580, 2 * (2 + 3)));
        assert_eq!((one.written_hz, one.read_hz), (Some(30.0), 29.0));
        assert_eq!(one.hop_us, Some(Figures { p50: 3.0, p99: 3.0 }));
        assert_eq!((one.recorded.sent, one.recorded.received, one.recorded.skipped), (5, 3, 2));
        let load = Load { backend: "shm".to_owned(), bytes: 16, period: 33_000_000 };
        assert_eq!(one.load(), Some(load));
        assert_eq!(report.failed(), 1);
    }
}
