//! The port `genom_state` (genom3.md 4.8).

use std::sync::atomic::{AtomicU64, Ordering};

use genom_types::Record;
use serde_json::{Value, json};

use crate::engine::Engine;
use crate::statistics::Durations;

/// How often it is written at least.
pub(crate) const PERIOD_NS: u64 = 1_000_000_000;

/// Date of the last value written.
#[derive(Debug, Default)]
pub(crate) struct StateClock {
    pub(crate) last: AtomicU64,
}

impl Engine {
    /// Publishes the state of the component, if it has the port.
    pub(crate) fn write_state(&self) {
        let plan = &self.shared.plan;
        self.state_clock.last.store(self.shared.clock.now(), Ordering::Relaxed);
        let Some(port) = plan.state_port() else { return };
        let Some(ty) = plan.port_type(port) else { return };
        let mut record = Record::new(ty);
        if let Err(error) = record.merge_json(&self.state()) {
            tracing::debug!(instance = self.name, "genom_state is of another type: {error}");
            return;
        }
        // One writer at a time, whichever thread it is.
        let _one = self.writing.lock();
        self.shared.body.write_port(port, &record);
    }

    /// When it has to be written again.
    pub(crate) fn state_due(&self) -> u64 {
        self.state_clock.last.load(Ordering::Relaxed) + PERIOD_NS
    }

    /// Writes it when the last value is old.
    pub(crate) fn refresh_state(&self) {
        if self.shared.clock.now() >= self.state_due() {
            self.write_state();
        }
    }

    fn state(&self) -> Value {
        let model = self.shared.plan.component();
        let activities = self.activities();
        let task = |(rank, task): (usize, &genom_description::model::Task)| {
            let shared = &self.shared.tasks[rank];
            let cycles = shared.figures.cycles.read();
            let list: Vec<Value> = activities
                .iter()
                .filter(|activity| activity.task == task.name)
                .map(|activity| {
                    let name = activity.service.as_deref().unwrap_or(&task.name);
                    json!({ "id": activity.id, "name": fit(name, 63) })
                })
                .collect();
            let period = shared.timing.map(|timing| timing.period);
            json!({
                "name": fit(&task.name, 63),
                "rusage": {
                    "cycles": cycles.count & 0xffff_ffff,
                    "timings": seconds(&cycles),
                    "load": load(&cycles, period),
                },
                "activity": list,
            })
        };
        let tasks: Vec<Value> = model.tasks.iter().enumerate().map(task).collect();
        json!({
            "task": tasks,
            "digest": fit(&model.digest, 32),
            "version": fit(&model.version, 31),
        })
    }
}

#[allow(clippy::cast_precision_loss)]
fn seconds(durations: &Durations) -> Value {
    let of = |ns: u64| ns as f64 * 1e-9;
    json!({
        "last": of(durations.last_ns),
        "max": of(durations.max_ns),
        "avg": of(durations.mean_ns),
    })
}

/// In percent of the period; zero for a task without.
#[allow(clippy::cast_precision_loss)]
fn load(durations: &Durations, period: Option<u64>) -> Value {
    let of = |ns: u64| period.map_or(0.0, |period| ns as f64 * 100.0 / period as f64);
    json!({
        "last": of(durations.last_ns),
        "max": of(durations.max_ns),
        "avg": of(durations.mean_ns),
    })
}

/// At most that many bytes, cut between characters.
fn fit(text: &str, bytes: usize) -> &str {
    let mut end = text.len().min(bytes);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}
