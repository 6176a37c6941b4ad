//! External events to components, and what changes in the daemon as it happens.

use std::convert::Infallible;
use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::response::sse::{Event, Sse};
use axum::{Extension, Json};
use serde::Serialize;
use serde_json::json;
use tokio_stream::Stream;
use utoipa::ToSchema;

use crate::bus::{Change, Heard};
use crate::daemon::Daemon;
use crate::rpc::components;
use crate::rpc::error::RpcError;
use crate::rpc::holder::Holder;
use crate::rpc::stream;

/// An event was fired.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Fired {
    fired: bool,
}

/// Fire an external event of a component.
#[utoipa::path(
    post,
    path = "/components/{component}/events/{event}",
    tag = "events",
    security(("token" = ["call"])),
    responses((status = 200, body = Fired), (status = 404))
)]
pub(crate) async fn fire(
    State(daemon): State<Arc<Daemon>>,
    Path((component, event)): Path<(String, String)>,
) -> Result<Json<Fired>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let sinks = &hosted.model().sinks;
    let Some(index) = sinks.iter().position(|sink| sink.name == event) else {
        let what = format!("{component} has no event");
        let names = sinks.iter().map(|sink| sink.name.as_str());
        return Err(RpcError::unknown("no_such_event", what, &event, names));
    };
    hosted.fire(index);
    daemon.bus.tell(&Change::EventFired { component, name: event });
    Ok(Json(Fired { fired: true }))
}

/// Follow what changes, from now on or since `Last-Event-ID`.
///
/// Server-sent events `change`; data is a JSON object whose `event` says what changed. The last
/// 1024 changes are kept for readers that are slow or were away. In place of older ones comes
/// `{"event": "missed", "changes": COUNT}`.
#[utoipa::path(
    get,
    path = "/events",
    tag = "events",
    security(("token" = ["read"])),
    params(("Last-Event-ID" = Option<u64>, Header, description = "Number of the last event heard")),
    responses((status = 200, content_type = "text/event-stream", body = String), (status = 503))
)]
pub(crate) async fn stream(
    State(daemon): State<Arc<Daemon>>,
    Extension(holder): Extension<Holder>,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, RpcError> {
    let after =
        headers.get("last-event-id").and_then(|id| id.to_str().ok()).and_then(|id| id.parse().ok());
    let mut listener = daemon.bus.listen(after);
    stream::open(&daemon, &holder, |writer| async move {
        loop {
            let heard = tokio::select! {
                heard = listener.next() => heard,
                () = writer.closed() => return,
            };
            let Some(heard) = heard else { return };
            if !writer.send(event(&heard)).await {
                return;
            }
        }
    })
}

fn event(heard: &Heard) -> Event {
    let (id, data) = match heard {
        Heard::Told(change) => (change.id, change.data.to_string()),
        Heard::Missed { count, last } => {
            (*last, json!({"event": "missed", "changes": count}).to_string())
        }
    };
    Event::default().event("change").id(id.to_string()).data(data)
}
