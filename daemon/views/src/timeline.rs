//! The changes of the last minutes with their dates.

use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::extract::State;
use axum::response::sse::Event;
use genom_doors::{Events, Holder, Parameters, RpcError, Streams};
use genom_ports::dates::Dates;
use genom_protocol::{Dated, Timeline, TimelineParameters};
use genom_supervisor::Supervisor;
use serde_json::Value;
use tokio::time::{MissedTickBehavior, interval};

/// How often it looks for new changes.
const LOOK: Duration = Duration::from_millis(100);
/// Changes in one event.
const MOST: usize = 512;

/// Stream the changes of the last minutes with their dates, and those that come.
///
/// Sends server-sent events `changes`, the first one at once. Changes are kept since the console
/// was opened or somebody asked for them first, for 10 minutes, at most 16,384; those of cells are
/// dated when the daemon hears of them. A reader that is too slow misses changes, which are counted;
/// one that reads nothing for 10 s is dropped.
#[utoipa::path(
    get,
    path = "/timeline/stream",
    tag = "events",
    params(TimelineParameters),
    responses(
        (status = 200, content_type = "text/event-stream", body = String), (status = 400),
        (status = 503)
    )
)]
pub async fn timeline(
    State(supervisor): State<Arc<Supervisor>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    Parameters(parameters): Parameters<TimelineParameters>,
) -> Result<Events, RpcError> {
    supervisor.bus.keep();
    let dates = Dates::of(&supervisor.clock);
    streams.open(&holder, move |writer| async move {
        let calendar = dates.calendar();
        let mut ticks = interval(LOOK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let (mut after, mut began) = (0, false);
        loop {
            tokio::select! {
                _ = ticks.tick() => {}
                () = writer.closed() => return,
            }
            loop {
                let excerpt = supervisor.bus.excerpt(after, MOST);
                let left = excerpt.left;
                after = excerpt.changes.last().map_or(after, |last| last.id);
                let wanted = excerpt.changes.iter().filter(|change| match &parameters.component {
                    Some(component) => concerns(&change.data, component),
                    None => true,
                });
                let changes: Vec<_> = wanted
                    .map(|change| Dated {
                        at: calendar.date(change.moment),
                        change: Value::clone(&change.data),
                    })
                    .collect();
                if changes.is_empty() && excerpt.missed == 0 && began && left == 0 {
                    break;
                }
                let first = !std::mem::replace(&mut began, true);
                let since = calendar.date(excerpt.since);
                let now = calendar.date(dates.moment());
                let told = Timeline { first, changes, now, since, missed: excerpt.missed };
                let text = serde_json::to_string(&told).unwrap_or_default();
                if !writer.send(Event::default().event("changes").data(text)).await {
                    return;
                }
                if left == 0 {
                    break;
                }
            }
        }
    })
}

/// Whether a change is of this component, or of none.
fn concerns(change: &Value, component: &str) -> bool {
    let text = |name: &str| change.get(name).and_then(Value::as_str);
    let within = |address: &str| address.split('/').next() == Some(component);
    match text("component") {
        Some(of) => of == component,
        None => {
            let mut ends =
                ["in", "out", "remote", "service"].into_iter().filter_map(text).peekable();
            ends.peek().is_none() || ends.any(within)
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_component_is_concerned_by_its_own_changes_its_connections_and_those_of_the_daemon() {
        for (change, is) in [
            (json!({"event": "overrun", "component": "demo"}), true),
            (json!({"event": "overrun", "component": "demo2"}), false),
            (json!({"event": "connected", "in": "other/a", "out": "demo/b"}), true),
            (json!({"event": "disconnected", "in": "demo2/a"}), false),
            (json!({"event": "stopping"}), true),
        ] {
            assert_eq!(concerns(&change, "demo"), is, "{change}");
        }
    }
}
