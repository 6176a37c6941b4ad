//! A report as rows of two tables.

use super::{ConnectionReport, Report, WayReport};
use crate::figures::Figures;

/// Header of [`Report::way_rows`].
pub const WAYS: [&str; 5] = ["WAY", "CPU", "MEMORY", "PROCESSES", "ERROR"];

/// Header of [`Report::connection_rows`].
pub const CONNECTIONS: [&str; 11] = [
    "WAY",
    "IN",
    "ON",
    "BYTES",
    "WRITTEN",
    "READ",
    "DROPPED",
    "LATENCY us",
    "HOP us",
    "FLOOR us",
    "x",
];

impl Report {
    /// A row for each way: what its processes take, or why it did not run.
    #[must_use]
    pub fn way_rows(&self) -> Vec<Vec<String>> {
        let row = |one: &WayReport| {
            vec![
                one.way.clone(),
                or_dash(one.cpu_percent, |cpu| format!("{cpu:.1} %")),
                or_dash(one.memory_bytes, megabytes),
                or_dash(one.processes, |count| count.to_string()),
                one.error.clone().unwrap_or_else(|| "-".to_owned()),
            ]
        };
        self.ways.iter().map(row).collect()
    }

    /// A row for each connection of each way.
    #[must_use]
    pub fn connection_rows(&self) -> Vec<Vec<String>> {
        let pair = |figures: Figures| format!("{} / {}", short(figures.p50), short(figures.p99));
        let row = |way: &WayReport, one: &ConnectionReport| {
            // Most pairs were not told apart from others.
            let unsure = if one.recorded.alike * 2 > one.recorded.received { "~" } else { "" };
            let floor = one.floor_us.map(|floor| floor.hop);
            let factor = one.hop_us.zip(floor).filter(|(_, floor)| floor.p50 > 0.0);
            vec![
                way.way.clone(),
                one.inport.clone(),
                one.backend.clone(),
                or_dash(one.sample_bytes, |bytes| format!("{bytes:.0}")),
                or_dash(one.written_hz, |rate| format!("{rate:.1}/s")),
                format!("{:.1}/s", one.read_hz),
                one.dropped().to_string(),
                or_dash(one.latency_us, |it| format!("{unsure}{}", pair(it))),
                or_dash(one.hop_us, |it| format!("{unsure}{}", pair(it))),
                or_dash(floor, pair),
                or_dash(factor, |(hop, floor)| format!("{:.1}", hop.p50 / floor.p50)),
            ]
        };
        let each = self.ways.iter().map(|way| way.connections.iter().map(move |one| row(way, one)));
        each.flatten().collect()
    }

    /// How many of the ways did not run.
    #[must_use]
    pub fn failed(&self) -> usize {
        self.ways.iter().filter(|way| way.error.is_some()).count()
    }
}

fn or_dash<T>(value: Option<T>, show: impl Fn(T) -> String) -> String {
    value.map_or_else(|| "-".to_owned(), show)
}

/// Three digits at least.
pub(crate) fn short(value: f64) -> String {
    match value {
        value if value < 10.0 => format!("{value:.2}"),
        value if value < 100.0 => format!("{value:.1}"),
        value => format!("{value:.0}"),
    }
}

#[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::report;

    #[test]
    fn rows_say_what_is_known_and_why_the_rest_is_not() {
        let report = report();
        assert_eq!(report.way_rows()[0], ["shm", "5.0 %", "30.0 MB", "2", "-"]);
        assert_eq!(report.way_rows()[1], ["ros2", "-", "-", "-", "no network"]);
        let row = &report.connection_rows()[0];
        assert_eq!(row[..4], ["shm", "viewer/image", "shm", "16"]);
        assert_eq!(row[4..7], ["30.0/s", "29.0/s", "10"]);
        assert_eq!(row[7..], ["1003 / 1003", "3.00 / 3.00", "1.50 / 2.00", "2.0"]);
        assert_eq!((row.len(), report.way_rows()[0].len()), (CONNECTIONS.len(), WAYS.len()));
    }
}
