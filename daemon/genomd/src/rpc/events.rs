//! External events of components, and changes in the daemon.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::response::sse::Event;
use axum::{Extension, Json};
use genom_doors::{Events, Holder, Parameters, RpcError, Streams, last_heard};
use genom_nearest::suggest;
use genom_protocol::{ChangeParameters, Code, Fired};
use genom_supervisor::Supervisor;
use genom_supervisor::bus::{Change, Heard};
use serde_json::json;
use strum::VariantNames as _;

use crate::rpc::components;

/// The kinds of changes that a listener asked for.
struct Wanted(Option<Vec<String>>);

/// Fire an external event of a component.
#[utoipa::path(
    post,
    path = "/components/{component}/events/{event}",
    tag = "events",
    responses((status = 200, body = Fired), (status = 404))
)]
pub(crate) async fn fire(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, event)): Path<(String, String)>,
) -> Result<Json<Fired>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let sinks = &hosted.model().sinks;
    let Some(index) = sinks.iter().position(|sink| sink.name == event) else {
        let what = format!("{component} has no event");
        let names = sinks.iter().map(|sink| sink.name.as_str());
        return Err(RpcError::unknown(Code::NoSuchEvent, what, &event, names));
    };
    hosted.fire(index);
    supervisor.bus.tell(&Change::EventFired { component, name: event });
    Ok(Json(Fired { fired: true }))
}

/// Stream changes in the daemon, from now on or since `Last-Event-ID`.
///
/// Sends server-sent events `change`; their data is a JSON object whose member `event` is the kind
/// of the change. The last 1024 changes are kept for readers that are slow or reconnect. Older ones
/// are replaced by `{"event": "missed", "changes": COUNT}`.
#[utoipa::path(
    get,
    path = "/events",
    tag = "events",
    params(
        ChangeParameters,
        ("Last-Event-ID" = Option<u64>, Header, description = "Number of the last event heard")
    ),
    responses(
        (status = 200, content_type = "text/event-stream", body = String), (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn stream(
    State(supervisor): State<Arc<Supervisor>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    headers: HeaderMap,
    Parameters(parameters): Parameters<ChangeParameters>,
) -> Result<Events, RpcError> {
    let wanted = Wanted::parse(parameters.only.as_deref())?;
    let after = last_heard(&headers);
    let mut listener = supervisor.bus.listen(after);
    streams.open(&holder, move |writer| async move {
        loop {
            let heard = tokio::select! {
                heard = listener.next() => heard,
                () = writer.closed() => return,
            };
            let Some(heard) = heard else { return };
            if !wanted.has(&heard) {
                continue;
            }
            if !writer.send(event(&heard)).await {
                return;
            }
        }
    })
}

impl Wanted {
    fn parse(only: Option<&str>) -> Result<Self, RpcError> {
        let Some(only) = only else { return Ok(Self(None)) };
        let kinds: Vec<_> = only.split(',').map(|kind| kind.trim().to_owned()).collect();
        match kinds.iter().find(|kind| !Change::VARIANTS.contains(&kind.as_str())) {
            None => Ok(Self(Some(kinds))),
            Some(kind) => Err(RpcError::bad_input(format!("there is no change `{kind}`"))
                .help(suggest(kind, Change::VARIANTS.iter().copied()))
                .place("only")),
        }
    }

    fn has(&self, heard: &Heard) -> bool {
        let (Some(kinds), Heard::Told(change)) = (&self.0, heard) else { return true };
        let kind = change.data["event"].as_str().unwrap_or_default();
        kind == "stopping" || kinds.iter().any(|wanted| wanted == kind)
    }
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use genom_supervisor::bus::Numbered;

    use super::*;

    fn told(change: &Change) -> Heard {
        let data = Arc::new(serde_json::to_value(change).unwrap());
        Heard::Told(Numbered { id: 1, moment: 0, data, teller: None })
    }

    #[test]
    fn a_listener_hears_the_changes_it_asked_for_and_the_end() {
        let wanted = Wanted::parse(Some("connected, event_fired")).unwrap();
        let fired = Change::EventFired { component: "demo".into(), name: "emergency".into() };
        assert!(wanted.has(&told(&fired)));
        assert!(!wanted.has(&told(&Change::Disconnected { inport: "demo/parameter".into() })));
        assert!(wanted.has(&told(&Change::Stopping {})));
        assert!(wanted.has(&Heard::Missed { count: 1, last: 1 }));
        assert!(Wanted::parse(None).unwrap().has(&told(&fired)));
        assert!(Wanted::parse(Some("conected")).is_err());
    }
}
