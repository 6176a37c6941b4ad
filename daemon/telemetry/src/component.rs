//! Metrics of a component: its tasks, codels, ports and connections.

use genom_runtime::Durations;
use genom_supervisor::components::Hosted;

use crate::page::Page;

/// A value that only grows.
pub const COUNTER: &str = "counter";
/// A value that goes up and down.
pub const GAUGE: &str = "gauge";

/// A count as a value of Prometheus.
#[must_use]
#[allow(clippy::cast_precision_loss, reason = "Prometheus knows no other number")]
pub fn count(value: u64) -> f64 {
    value as f64
}

/// Adds what is counted and measured of a component.
pub fn describe(page: &mut Page, hosted: &Hosted) {
    let component = hosted.name.as_str();
    let own = [("component", component)];
    let backend = hosted.ties.bindings.component().to_string();
    page.add("genom_component", GAUGE, "A component runs.", &[own[0], ("backend", &backend)], 1.0);
    let running = hosted.activities.running();
    page.add("genom_activities", GAUGE, "Activities that run.", &own, count(running as u64));
    let statistics = hosted.figures();
    for task in &statistics.tasks {
        let labels = [own[0], ("task", task.name.as_str())];
        let help = "Ticks that came while the task was at work, or slept beyond the one before.";
        page.add("genom_task_overruns_total", COUNTER, help, &labels, count(task.overruns));
        let help = "Time in the codel that the task is stuck in; 0 when it is not.";
        let stuck = task.stuck.as_ref().map_or(0, |codel| codel.for_ns);
        page.add("genom_task_stuck_seconds", GAUGE, help, &labels, count(stuck) / 1e9);
        durations(page, "genom_task_work_seconds", "Time at work, by tick.", &labels, &task.cycles);
        let help = "From the date of a tick to the start of work.";
        durations(page, "genom_task_lateness_seconds", help, &labels, &task.lateness);
        let (help, value) =
            ("Whether the task has a real-time priority.", u8::from(task.real_time));
        page.add("genom_task_real_time", GAUGE, help, &labels, f64::from(value));
    }
    for rule in hosted.rules() {
        let labels = [own[0], ("kind", rule.kind.name()), ("rule", rule.rule.as_str())];
        let help = "Times that a rule of supervision was broken.";
        let name = "genom_supervision_violations_total";
        page.add(name, COUNTER, help, &labels, count(rule.violations));
    }
    for codel in &statistics.codels {
        let labels = [own[0], ("owner", codel.owner.as_str()), ("codel", codel.name.as_str())];
        durations(page, "genom_codel_seconds", "Time in a codel.", &labels, &codel.durations);
        for (event, times) in &codel.yielded {
            let labels = [labels[0], labels[1], labels[2], ("event", event.as_str())];
            let help = "What a codel returned.";
            page.add("genom_codel_yields_total", COUNTER, help, &labels, count(*times));
        }
        let help = "Calls longer than the stated wcet.";
        page.add("genom_codel_above_wcet_total", COUNTER, help, &labels, count(codel.above_wcet));
    }
    for index in hosted.model().ports.places() {
        for key in hosted.elements(index) {
            let Some(gauge) = hosted.ties.gauge(&key) else { continue };
            let (counts, address) = (gauge.counts(), hosted.port_address(&key).to_string());
            let connection = hosted.ties.connection(&key);
            let (kind, mut labels) = match &connection {
                Some(_) => ("connection", vec![("in", address.as_str())]),
                None => ("port", vec![("port", address.as_str())]),
            };
            let outport = connection.as_ref().map(|made| made.outport.to_string());
            if let (Some(made), Some(outport)) = (&connection, &outport) {
                labels.extend([("out", outport.as_str()), ("backend", made.backend.as_str())]);
            }
            for (what, help, value) in [
                ("samples", "Samples written, or new ones read.", counts.samples),
                ("dropped", "Samples that the middleware gave up.", counts.dropped),
                ("failed", "Writes or reads that failed.", counts.failed),
            ] {
                let name = format!("genom_{kind}_{what}_total");
                page.add(&name, COUNTER, help, &labels, count(value));
            }
        }
    }
}

/// Adds the distribution of durations, in seconds.
fn durations(page: &mut Page, name: &str, help: &str, labels: &[(&str, &str)], of: &Durations) {
    let quantiles = [("0", of.min_ns), ("0.5", of.p50_ns), ("0.99", of.p99_ns), ("1", of.max_ns)];
    let quantiles = quantiles.map(|(quantile, ns)| (quantile, count(ns) / 1e9));
    let sum = count(of.mean_ns) * count(of.count) / 1e9;
    page.summary(name, help, labels, &quantiles, (sum, count(of.count)));
}
