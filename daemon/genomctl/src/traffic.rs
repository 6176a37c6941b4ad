//! Rates of a port, computed from two readings of its counters: exact at any rate.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Address, Traffic, routes};
use serde_json::{Value, json};
use tokio::signal::unix::{SignalKind, signal};

use crate::complete::Names;
use crate::failure::Failure;
use crate::names::{address, element};
use crate::session::Session;

/// Unit of the intervals whose squares are summed, in nanoseconds.
#[allow(clippy::cast_precision_loss, reason = "it is small")]
const UNIT: f64 = Traffic::UNIT as f64;

/// What passed through a port between two readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rate {
    /// Number of samples.
    pub(crate) samples: u64,
    /// Samples per second, if there were at least two.
    pub(crate) hertz: Option<f64>,
    /// Standard deviation of the intervals, in seconds.
    pub(crate) jitter: f64,
    /// Mean size of a sample in bytes, if any was measured.
    pub(crate) size: Option<f64>,
}

/// Reads the counters of a port.
pub(crate) async fn reading(session: &Session, at: &Address) -> Result<Traffic, Failure> {
    let route = routes::traffic(&at.component, &at.port).with(&element(at));
    Ok(session.ask(route).await?.content.traffic)
}

/// The difference between two readings.
#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
fn between(earlier: &Traffic, now: &Traffic) -> Rate {
    let samples = now.counts.samples.saturating_sub(earlier.counts.samples);
    let (start, intervals) = match earlier.last_ns {
        Some(last) => (Some(last), samples),
        // The first sample does not end an interval.
        None => (now.first_ns, samples.saturating_sub(1)),
    };
    let span = now.last_ns.zip(start).map_or(0, |(end, start)| end.saturating_sub(start));
    let (hertz, jitter) = if intervals == 0 || span == 0 {
        (None, 0.0)
    } else {
        let mean = span as f64 / intervals as f64;
        let squares = now.squares.wrapping_sub(earlier.squares) as f64 * UNIT * UNIT;
        let variance = (squares / intervals as f64 - mean * mean).max(0.0);
        // Intervals are rounded down to the unit: smaller deviations are no jitter.
        let deviation = variance.sqrt();
        (Some(1e9 / mean), if deviation < UNIT { 0.0 } else { deviation / 1e9 })
    };
    let weighed = now.weighed.saturating_sub(earlier.weighed);
    let bytes = now.bytes.wrapping_sub(earlier.bytes);
    let size = (weighed > 0).then(|| bytes as f64 / weighed as f64);
    Rate { samples, hertz, jitter, size }
}

impl Rate {
    /// Bytes per second.
    pub(crate) fn bandwidth(&self) -> Option<f64> {
        Some(self.hertz? * self.size?)
    }

    /// The rate as data, for `--json`.
    pub(crate) fn data(&self, port: &Address) -> Value {
        json!({
            "address": port.to_string(), "samples": self.samples, "hertz": self.hertz,
            "jitter": self.jitter, "sample_bytes": self.size,
            "bytes_per_second": self.bandwidth(),
        })
    }
}

/// The traffic of a port, as the command line asks for it.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Watch {
    /// The port: COMPONENT/PORT or COMPONENT/PORT/ELEMENT.
    #[arg(value_parser = address, add = ArgValueCompleter::from(Names::Ports))]
    port: Address,
    /// Stop after this many lines.
    #[arg(short = 'n', long, value_name = "COUNT")]
    count: Option<u64>,
    /// Seconds that each line is about.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    window: f64,
    /// Print one line on everything since the port was opened or connected.
    #[arg(long, conflicts_with_all = ["count", "window"])]
    total: bool,
}

impl Watch {
    /// Prints one line per window, until Ctrl-C.
    pub(crate) async fn run(
        &self,
        session: &Session,
        render: fn(&Rate) -> String,
    ) -> Result<(), Failure> {
        let port = &self.port;
        let show = |rate: &Rate| {
            let text = if session.json { rate.data(port).to_string() } else { render(rate) };
            session.print(&format!("{text}\n"))
        };
        if self.total {
            return show(&between(&Traffic::default(), &reading(session, port).await?));
        }
        let window = std::time::Duration::try_from_secs_f64(self.window)
            .ok()
            .filter(|window| !window.is_zero())
            .ok_or_else(|| {
                Failure::usage(format!("--window {}: no time to count in", self.window), "try 1")
            })?;
        // Before anything is printed: a reader of the first line may send the interrupt at once.
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut ticks = tokio::time::interval(window);
        ticks.tick().await;
        let mut before = reading(session, port).await?;
        for _ in 0..self.count.unwrap_or(u64::MAX) {
            tokio::select! {
                _ = ticks.tick() => {}
                _ = interrupt.recv() => return Ok(()),
            }
            let now = reading(session, port).await?;
            show(&between(&before, &now))?;
            before = now;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_protocol::Counts;

    fn reading(samples: u64, last_ms: u64, squares: u64) -> Traffic {
        Traffic {
            counts: Counts { samples, ..Counts::default() },
            first_ns: Some(0),
            last_ns: Some(last_ms * 1_000_000),
            squares,
            weighed: samples,
            bytes: samples * 8,
            ..Traffic::default()
        }
    }

    #[test]
    fn a_steady_port_has_its_rate_and_no_jitter() {
        // 5 ms are 50,000 units.
        let square = 50_000_u64.pow(2);
        let before = reading(100, 495, 99 * square);
        let after = reading(300, 1_495, 299 * square);
        let rate = between(&before, &after);
        assert_eq!((rate.samples, rate.hertz, rate.jitter), (200, Some(200.0), 0.0));
        assert_eq!(rate.bandwidth(), Some(1600.0));
        let total = between(&Traffic::default(), &before);
        assert_eq!((total.samples, total.hertz), (100, Some(200.0)));
    }

    #[test]
    fn uneven_intervals_are_jitter() {
        // Alternating 4 ms and 6 ms: 1 ms around the mean.
        let squares = 40_000_u64.pow(2) + 60_000_u64.pow(2);
        let rate = between(&Traffic::default(), &reading(3, 10, squares));
        assert_eq!(rate.hertz, Some(200.0));
        assert!((rate.jitter - 0.001).abs() < 1e-9, "{}", rate.jitter);
    }

    #[test]
    fn silence_has_no_rate() {
        let rate = between(&reading(5, 20, 0), &reading(5, 20, 0));
        assert_eq!((rate.samples, rate.hertz, rate.size), (0, None, None));
        assert_eq!(between(&Traffic::default(), &Traffic::default()).hertz, None);
    }
}
