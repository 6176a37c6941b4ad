//! The port `genom_state` (genom3.md 4.8).

use std::sync::atomic::Ordering;

use genom_description::model::{Task, TaskIx};
use genom_types::Record;
use serde_json::{Value, json};

use super::window::{Totals, Window};
use crate::cycles::Total;
use crate::engine::Engine;
use crate::lock::lock;
use crate::shared::TaskShared;

/// Longest time between two writes, in nanoseconds.
pub(crate) const PERIOD_NS: u64 = 1_000_000_000;

impl Engine {
    /// Publishes the state of the component, if it has the port.
    pub(crate) fn write_state(&self) {
        let plan = &self.shared.plan;
        self.state_written.store(self.shared.clock.now(), Ordering::Relaxed);
        let Some(port) = plan.state_port() else { return };
        let Some(ty) = plan.port_type(port) else { return };
        let mut record = Record::new(ty);
        // Serialises writers, so that values are published in the order of their dates.
        let mut recent = lock(&self.recent);
        if let Err(error) = record.merge_json(&self.state(&mut recent)) {
            tracing::debug!(instance = self.name, "genom_state is of another type: {error}");
            return;
        }
        self.shared.body.write_port(port, &record);
    }

    /// Date at which it has to be written again.
    pub(crate) fn state_due(&self) -> u64 {
        self.state_written.load(Ordering::Relaxed) + PERIOD_NS
    }

    /// Writes it if the last value is old.
    pub(crate) fn refresh_state(&self) {
        if self.shared.clock.now() >= self.state_due() {
            self.write_state();
        }
    }

    fn state(&self, recent: &mut [Window]) -> Value {
        let model = self.shared.plan.component();
        let activities = self.activities();
        let task = |((ix, task), window): ((TaskIx, &Task), &mut Window)| {
            let shared = &self.shared.tasks[ix];
            let list: Vec<Value> = activities
                .iter()
                .filter(|activity| activity.task == task.name)
                .map(|activity| {
                    let name = activity.service.as_deref().unwrap_or(&task.name);
                    json!({ "id": activity.id, "name": fit(name, 63) })
                })
                .collect();
            json!({
                "name": fit(&task.name, 63),
                "rusage": rusage(shared, window, self.shared.clock.now()),
                "activity": list,
            })
        };
        let tasks: Vec<Value> = model.tasks.pairs().zip(recent).map(task).collect();
        json!({
            "task": tasks,
            "digest": fit(&model.digest, 32),
            "date": fit(&lock(&self.date), 30),
            "version": fit(&model.version, 31),
        })
    }
}

/// Statistics of a task in seconds and percent: averages over about ten seconds, maxima since the
/// start.
///
/// The load of a periodic task is relative to its period, so that overruns show; that of an
/// aperiodic one is its share of the time, and its last value is that of the last second.
#[allow(clippy::cast_precision_loss)]
fn rusage(task: &TaskShared, window: &mut Window, date: u64) -> Value {
    let durations = task.figures.cycles.read(date);
    let Total { cycles, busy_ns } = task.figures.cycles.total(date);
    let recent = window.look(Totals { date, cycles, busy_ns });
    let seconds = |ns: f64| ns * 1e-9;
    let (last, max) = (durations.last_ns as f64, durations.max_ns as f64);
    let (last_load, max_load) = match task.timing {
        Some(timing) => {
            let of_period = |ns: f64| ns * 100.0 / timing.period as f64;
            (of_period(last), of_period(max))
        }
        None => (recent.last_load, recent.max_load),
    };
    json!({
        "cycles": cycles & 0xffff_ffff,
        "timings": { "last": seconds(last), "max": seconds(max), "avg": seconds(recent.mean_ns) },
        "load": { "last": last_load, "max": max_load, "avg": recent.load },
    })
}

/// A prefix of at most `bytes` bytes, cut between characters.
fn fit(text: &str, bytes: usize) -> &str {
    let mut end = text.len().min(bytes);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

#[cfg(test)]
#[path = "state_port_tests.rs"]
mod tests;
