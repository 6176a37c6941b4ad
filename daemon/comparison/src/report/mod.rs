//! What a comparison found, as data.

mod rows;
mod runs;

use serde::{Deserialize, Serialize};

use crate::figures::Figures;
use crate::floor::{Floor, Load};
pub(crate) use rows::short;
pub use rows::{CONNECTIONS, WAYS};
pub use runs::{Measured, Run, Runs};

/// A comparison.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Report {
    /// The deployment file.
    pub deployment: String,
    /// What `genomd --version` prints first.
    pub genomd: String,
    /// Processors of the machine that this process may use.
    pub processors: usize,
    /// Seconds that each run was measured for, first its counters, then its samples.
    pub seconds: f64,
    /// Seconds before that.
    pub warm_up: f64,
    /// How often each way was run.
    pub runs: u32,
    /// Whether each component was in a process of its own.
    pub isolated: bool,
    /// The ways, in the order in which they were asked for.
    pub ways: Vec<WayReport>,
}

/// What was found of one way.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct WayReport {
    /// The way, as it is written: `shm`, `shm: camera/image=zenoh`.
    pub way: String,
    /// Why it could not be run, if so; what follows is then of the runs before.
    pub error: Option<String>,
    /// Processor time of the daemon and all its processes: 100 is one processor.
    pub cpu_percent: Option<f64>,
    /// Memory of these processes in bytes; what they share counts once.
    pub memory_bytes: Option<u64>,
    /// How many processes there are.
    pub processes: Option<usize>,
    /// The connections of ports.
    pub connections: Vec<ConnectionReport>,
}

/// What was found of one connection.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ConnectionReport {
    /// The in port.
    #[serde(rename = "in")]
    pub inport: String,
    /// The out port.
    #[serde(rename = "out")]
    pub outport: String,
    /// The middleware.
    pub backend: String,
    /// Which unread samples are kept.
    pub policy: String,
    /// Mean size of a sample in bytes: in memory, or encoded if the size varies.
    pub sample_bytes: Option<f64>,
    /// Samples written a second; absent if the out port is not in the deployment.
    pub written_hz: Option<f64>,
    /// New samples read a second.
    pub read_hz: f64,
    /// Samples written while counters were measured.
    pub written: Option<u64>,
    /// New samples read meanwhile.
    pub read: u64,
    /// Samples dropped on the writing side, for all readers of the port together.
    pub dropped_by_writer: u64,
    /// Samples dropped on the reading side.
    pub dropped_by_reader: u64,
    /// Writes and reads that failed.
    pub failed: u64,
    /// From the beginning of `write` to the end of the `read` that returned the sample, in us.
    pub latency_us: Option<Figures>,
    /// The same without the time that the sample could have been read but was not, in us.
    pub hop_us: Option<Figures>,
    /// The samples that both are of.
    pub recorded: Recorded,
    /// The bare middleware with values of this size and rate, in us.
    pub floor_us: Option<Floor>,
    /// Why there is none, if it was asked for.
    pub floor_error: Option<String>,
}

/// Samples of a connection whose times were recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Recorded {
    /// Written, from the first to the last one that was read.
    pub sent: u64,
    /// Read: `sent` without `skipped`.
    pub received: u64,
    /// Never read: lost, or replaced by newer ones.
    pub skipped: u64,
    /// Read, and not told apart from another one of the same content.
    pub alike: u64,
    /// Read, but written before the recording.
    pub unknown: u64,
}

impl ConnectionReport {
    /// What the bare middleware is to be loaded with to be compared; `None` if nothing flowed.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a size and a period, rounded"
    )]
    pub fn load(&self) -> Option<Load> {
        let (bytes, rate) = (self.sample_bytes?, self.written_hz?);
        let period = (rate > 0.0).then_some(1e9 / rate)?;
        // Measured rates differ a little from way to way; two digits are compared with one floor.
        let digits = 10_f64.powi(period.log10().floor() as i32 - 1);
        let period = ((period / digits).round() * digits) as u64;
        let backend = self.backend.split('+').next().unwrap_or_default().to_owned();
        Some(Load { backend, bytes: (bytes.round() as u64).max(1), period })
    }

    /// Samples dropped on either side.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped_by_writer + self.dropped_by_reader
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::runs::tests::run;
    use super::*;

    pub(crate) fn report() -> Report {
        let mut shm = Runs::of("shm");
        shm.add(Ok(run(&[2_000, 4_000])));
        shm.add(Ok(run(&[3_000])));
        let mut ros2 = Runs::of("ros2");
        ros2.add(Err("no network".to_owned()));
        let mut ways = vec![shm.report(), ros2.report()];
        let hop = Figures { p50: 1.5, p99: 2.0 };
        ways[0].connections[0].floor_us = Some(Floor { hop, values: 9, lost: 0 });
        Report {
            deployment: "robot.toml".to_owned(),
            genomd: "genomd 1.0".to_owned(),
            processors: 4,
            seconds: 10.0,
            warm_up: 2.0,
            runs: 2,
            isolated: false,
            ways,
        }
    }

    #[test]
    fn a_report_is_read_back_from_its_json() {
        let report = report();
        let text = serde_json::to_string(&report).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
    }
}
