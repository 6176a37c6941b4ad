//! Metrics in the text format of Prometheus: components, tasks, codels, ports, connections.

use std::fmt::Write as _;
use std::sync::Arc;

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use genom_cells::Cells;
use genom_protocol::{CellState, routes};
use genom_runtime::Durations;
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;

use crate::rpc::ports;

/// Get metrics in the text format of Prometheus.
#[utoipa::path(
    get,
    path = "/metrics",
    tag = "statistics",
    responses((status = 200, content_type = "text/plain", body = String))
)]
pub(crate) async fn text(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> impl IntoResponse {
    let mut page = Page::default();
    for hosted in supervisor.components.all() {
        describe(&mut page, &hosted);
    }
    let open =
        genom_registry::known().iter().filter_map(|known| supervisor.backends.opened(known.name));
    for open in open {
        for refused in open.refused() {
            let labels = [("backend", open.name()), ("why", refused.why)];
            let help = "Messages of peers that would have harmed, and were refused.";
            page.add("genom_refused_total", COUNTER, help, &labels, count(refused.count));
        }
    }
    for cell in cells.all() {
        let told = cell.told();
        let labels = [("cell", told.name.as_str())];
        let up = u8::from(told.state == CellState::Running);
        page.add("genom_cell_up", GAUGE, "Whether a cell runs.", &labels, f64::from(up));
        let help = "Processes of a cell that were started.";
        page.add("genom_cell_starts_total", COUNTER, help, &labels, count(told.starts));
        if let Ok(theirs) = cell.text(&routes::metrics()).await {
            page.join(&told.name, &theirs);
        }
    }
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], page.text())
}

fn describe(page: &mut Page, hosted: &Hosted) {
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
        page.durations("genom_task_work_seconds", "Time at work, by tick.", &labels, &task.cycles);
        let help = "From the date of a tick to the start of work.";
        page.durations("genom_task_lateness_seconds", help, &labels, &task.lateness);
        let (help, value) =
            ("Whether the task has a real-time priority.", u8::from(task.real_time));
        page.add("genom_task_real_time", GAUGE, help, &labels, f64::from(value));
    }
    for codel in &statistics.codels {
        let labels = [own[0], ("owner", codel.owner.as_str()), ("codel", codel.name.as_str())];
        page.durations("genom_codel_seconds", "Time in a codel.", &labels, &codel.durations);
        let help = "Calls longer than the stated wcet.";
        page.add("genom_codel_above_wcet_total", COUNTER, help, &labels, count(codel.above_wcet));
    }
    for index in hosted.model().ports.places() {
        for key in ports::elements(hosted, index) {
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

const COUNTER: &str = "counter";
const GAUGE: &str = "gauge";

#[allow(clippy::cast_precision_loss, reason = "Prometheus knows no other number")]
fn count(value: u64) -> f64 {
    value as f64
}

/// The page. Samples are grouped by name, because Prometheus requires those of one name to be
/// adjacent.
#[derive(Default)]
struct Page {
    families: indexmap::IndexMap<String, String>,
}

impl Page {
    fn add(&mut self, name: &str, kind: &str, help: &str, labels: &[(&str, &str)], value: f64) {
        let family = self.family(name, kind, help);
        sample(family, name, labels, value);
    }

    fn durations(&mut self, name: &str, help: &str, labels: &[(&str, &str)], of: &Durations) {
        let family = self.family(name, "summary", help);
        for (quantile, ns) in [("0.5", of.p50_ns), ("0.99", of.p99_ns), ("1", of.max_ns)] {
            let labels = [labels, &[("quantile", quantile)]].concat();
            sample(family, name, &labels, count(ns) / 1e9);
        }
        let sum = count(of.mean_ns) * count(of.count) / 1e9;
        sample(family, &format!("{name}_sum"), labels, sum);
        sample(family, &format!("{name}_count"), labels, count(of.count));
    }

    fn family(&mut self, name: &str, kind: &str, help: &str) -> &mut String {
        self.families
            .entry(name.to_owned())
            .or_insert_with(|| format!("# HELP {name} {help}\n# TYPE {name} {kind}\n"))
    }

    /// Adds the page of a cell: each sample with the cell as its first label.
    fn join(&mut self, cell: &str, page: &str) {
        let mut family = String::new();
        for line in page.lines() {
            if let Some(about) = line.strip_prefix("# HELP ") {
                family = about.split(' ').next().unwrap_or_default().to_owned();
            }
            let known = self.families.contains_key(&family);
            if line.starts_with("# HELP ") && !known {
                self.families.insert(family.clone(), format!("{line}\n"));
            } else if line.starts_with("# TYPE ") {
                let text = self.families.entry(family.clone()).or_default();
                if text.lines().count() == 1 {
                    text.push_str(&format!("{line}\n"));
                }
            } else if !line.starts_with('#') {
                let labelled = match line.split_once('{') {
                    Some((name, rest)) => format!("{name}{{cell=\"{cell}\",{rest}\n"),
                    None => line.replacen(' ', &format!("{{cell=\"{cell}\"}} "), 1) + "\n",
                };
                self.families.entry(family.clone()).or_default().push_str(&labelled);
            }
        }
    }

    fn text(self) -> String {
        self.families.into_values().collect()
    }
}

fn sample(out: &mut String, name: &str, labels: &[(&str, &str)], value: f64) {
    out.push_str(name);
    for (rank, (label, text)) in labels.iter().enumerate() {
        let text = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        let _ = write!(out, "{}{label}=\"{text}\"", if rank == 0 { '{' } else { ',' });
    }
    let _ = writeln!(out, "{}{value}", if labels.is_empty() { " " } else { "} " });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_cells_are_joined_by_name_with_the_cell_as_a_label() {
        let mut page = Page::default();
        page.add("a_total", COUNTER, "A.", &[("x", "one")], 1.0);
        let mut far = Page::default();
        far.add("a_total", COUNTER, "A.", &[("x", "two")], 2.0);
        far.add("b", GAUGE, "B.", &[], 0.5);
        page.join("arm", &far.text());
        let text = "# HELP a_total A.\n# TYPE a_total counter\na_total{x=\"one\"} 1\n\
            a_total{cell=\"arm\",x=\"two\"} 2\n# HELP b B.\n# TYPE b gauge\nb{cell=\"arm\"} 0.5\n";
        assert_eq!(page.text(), text);
    }

    #[test]
    fn samples_of_one_name_stand_together_and_labels_are_escaped() {
        let mut page = Page::default();
        page.add("a_total", COUNTER, "A.", &[("x", "one")], 1.0);
        page.add("b", GAUGE, "B.", &[], 0.5);
        page.add("a_total", COUNTER, "A.", &[("x", "t\"w\\o\n"), ("y", "z")], 2.0);
        let text = "# HELP a_total A.\n# TYPE a_total counter\na_total{x=\"one\"} 1\n\
            a_total{x=\"t\\\"w\\\\o\\n\",y=\"z\"} 2\n# HELP b B.\n# TYPE b gauge\nb 0.5\n";
        assert_eq!(page.text(), text);
    }
}
