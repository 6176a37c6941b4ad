//! Metrics in the text format of Prometheus: of components, middlewares and cells.

use std::sync::Arc;

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;
use genom_cells::Cells;
use genom_protocol::{CellState, routes};
use genom_supervisor::Supervisor;
use genom_telemetry::{COUNTER, GAUGE, Page, count, describe};

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
        // A gateway may take a moment to answer.
        for refused in tokio::task::block_in_place(|| open.refused()) {
            let labels = [("backend", open.name()), ("why", &refused.why)];
            let help = "Messages of peers that would have harmed, and were refused.";
            page.add("genom_refused_total", COUNTER, help, &labels, count(refused.count));
        }
    }
    for cell in cells.with_gateways() {
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
