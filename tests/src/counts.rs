//! Counters of one out port, and of the task and the codel that write it.

use std::path::Path;

use serde_json::Value;

use crate::{Daemon, request};

/// Counters since the component was loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Ticks of the task.
    pub ticks: u64,
    /// Ticks that the task missed.
    pub missed: u64,
    /// Runs of the codel.
    pub runs: u64,
    /// Samples written.
    pub written: u64,
    /// Writes that failed.
    pub failed: u64,
    /// Samples that the middleware dropped.
    pub dropped: u64,
}

impl Daemon {
    /// Counters of a component's first task, one of its codels and one of its out ports. They are
    /// consistent with each other only while a stepped clock stands still.
    #[track_caller]
    #[must_use]
    pub fn counts(&self, component: &str, codel: &str, port: &str) -> Counts {
        let stats = self.json(&["stats", component]);
        let traffic = self.port(component, port)["traffic"].clone();
        let task = &stats["tasks"][0];
        let codels = stats["codels"].as_array().expect("codels");
        let codel = codels.iter().find(|found| found["name"] == codel);
        let number = |value: &Value| value.as_u64().expect("a number");
        Counts {
            ticks: number(&task["cycles"]["count"]),
            missed: number(&task["overruns"]),
            // A codel that never ran is not listed.
            runs: codel.map_or(0, |codel| number(&codel["durations"]["count"])),
            written: number(&traffic["samples"]),
            failed: number(&traffic["failed"]),
            dropped: number(&traffic["dropped"]),
        }
    }

    /// Steps the virtual clock. When this returns, all ticks within that time have been run.
    #[track_caller]
    pub fn step(&self, milliseconds: u64) {
        step(&self.home().socket(), milliseconds);
    }
}

/// The same, for another thread.
///
/// # Panics
/// If the daemon refuses because its clock is the machine's.
#[track_caller]
pub fn step(socket: &Path, milliseconds: u64) {
    let body = format!(r#"{{"nanoseconds":{}}}"#, milliseconds * 1_000_000);
    let reply = request(socket, "POST", "/clock", &body);
    assert_eq!(reply.status, 200, "{reply:?}");
}
