//! The daemon's log: latest entries, and a stream of new ones.

use std::sync::Arc;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::Event;
use axum::{Extension, Json};
use genom_doors::{Events, Holder, Parameters, RpcError, Streams, last_heard};
use genom_protocol::{LogEntry, LogParameters, Logs};
use genom_supervisor::Supervisor;
use genom_supervisor::bus::Heard;
use genom_telemetry::logs;
use genom_telemetry::selection::{Selection, UnknownLevel};
use serde::Deserialize as _;
use serde_json::{Value, json};

use crate::rpc::components;

fn no_level(unknown: UnknownLevel) -> RpcError {
    RpcError::bad_input(unknown.to_string()).place("level").help(unknown.help())
}

/// Get the latest entries of the daemon's log.
#[utoipa::path(
    get,
    path = "/logs",
    tag = "logs",
    params(LogParameters),
    responses((status = 200, body = Logs), (status = 404), (status = 422))
)]
pub(crate) async fn list(
    State(supervisor): State<Arc<Supervisor>>,
    Parameters(parameters): Parameters<LogParameters>,
) -> Result<Json<Logs>, RpcError> {
    let LogParameters { level, component, last } = parameters;
    let wanted = Selection::new(level.as_deref(), component).map_err(no_level)?;
    let all = logs::past().listen(Some(0)).take_past();
    // Entries about a component that was unloaded remain available; a name without entries must be
    // that of a component.
    if let Some(name) = &wanted.component
        && !all.iter().any(|entry| entry.data["component"] == *name.as_str())
    {
        components::find(&supervisor.components, name)?;
    }
    let entries = wanted.latest(all, last);
    let logs = entries.iter().filter_map(|entry| LogEntry::deserialize(&*entry.data).ok());
    Ok(Json(Logs { logs: logs.collect() }))
}

/// Stream entries of the daemon's log, starting with the latest `last` entries, or since
/// `Last-Event-ID`.
///
/// The last 1024 entries are kept for readers that are slow or reconnect. An entry that says so
/// replaces those that were missed.
#[utoipa::path(
    get,
    path = "/logs/stream",
    tag = "logs",
    params(
        LogParameters,
        ("Last-Event-ID" = Option<u64>, Header, description = "Number of the last entry heard")
    ),
    responses(
        (status = 200, content_type = "text/event-stream", body = String), (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn stream(
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    headers: HeaderMap,
    Parameters(parameters): Parameters<LogParameters>,
) -> Result<Events, RpcError> {
    let LogParameters { level, component, last } = parameters;
    let wanted = Selection::new(level.as_deref(), component).map_err(no_level)?;
    let after = last_heard(&headers);
    let mut listener = logs::past().listen(after.or(Some(0)));
    let past = match after {
        None => wanted.latest(listener.take_past(), Some(last.unwrap_or(0))),
        Some(_) => Vec::new(),
    };
    streams.open(&holder, move |writer| async move {
        for entry in past {
            if !writer.send(event(entry.id, &entry.data)).await {
                return;
            }
        }
        loop {
            let heard = tokio::select! {
                heard = listener.next() => heard,
                () = writer.closed() => return,
            };
            let event = match heard {
                None => return,
                Some(Heard::Told(entry)) if !wanted.has(&entry) => continue,
                Some(Heard::Told(entry)) => event(entry.id, &entry.data),
                Some(Heard::Missed { count, last }) => event(last, &json!(logs::missed(count))),
            };
            if !writer.send(event).await {
                return;
            }
        }
    })
}

fn event(id: u64, entry: &Value) -> Event {
    Event::default().event("log").id(id.to_string()).data(entry.to_string())
}
