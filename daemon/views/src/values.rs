//! Streams of a port's values.

use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::extract::{Path, State};
use axum::response::sse::Event;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use genom_doors::{Events, Holder, Parameters, RpcError, Streams, Writer};
use genom_ports::dates::Dates;
use genom_protocol::{Form, StreamEnd, StreamParameters};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use serde_json::{Value, json};
use tokio::time::{MissedTickBehavior, interval};

use crate::named::{find, key};

/// Default of `rate`, in values per second.
const USUAL_RATE: f64 = 50.0;
/// Maximum of `rate`, in values per second.
const GREATEST_RATE: f64 = 1000.0;

/// Stream the values of a port.
///
/// Sends server-sent events `value` whenever the value differs from the last one sent, and at first
/// if there is a value. The `id` of an event is the date of the sample, in nanoseconds since 1970
/// or of the virtual clock. Event `end` is sent when the component is unloaded. A reader that is
/// too slow misses values; one that reads nothing for 10 s is dropped.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}/stream",
    tag = "ports",
    params(StreamParameters),
    responses(
        (status = 200, content_type = "text/event-stream", body = String), (status = 404),
        (status = 422), (status = 503)
    )
)]
pub async fn stream(
    State(supervisor): State<Arc<Supervisor>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<StreamParameters>,
) -> Result<Events, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    let key = key(&hosted, &port, parameters.element)?;
    let rate = parameters.rate.unwrap_or(USUAL_RATE);
    if !(rate > 0.0 && rate <= GREATEST_RATE) {
        let message = format!("rate: {rate} is not between 0 and {GREATEST_RATE} values a second");
        return Err(RpcError::bad_input(message).place("rate"));
    }
    let form = parameters.form.unwrap_or_default();
    let dates = Dates::of(&supervisor.clock);
    streams.open(&holder, move |writer| async move {
        let date = || {
            let gauge = hosted.ties.gauge(&key);
            let age = gauge.and_then(|gauge| gauge.counts().age_ns).unwrap_or_default();
            dates.now().saturating_sub(age)
        };
        match form {
            Form::Json => {
                let look = || Some((hosted.port_value(&key)?, date()));
                follow(&hosted, rate, &writer, look, Value::to_string).await;
            }
            Form::Message => {
                let look = || Some((hosted.port_message(&key)?, date()));
                let text = |message: &Vec<u8>| BASE64.encode(message);
                follow(&hosted, rate, &writer, look, text).await;
            }
        }
    })
}

/// Sends what `look` returns, with its date, whenever it changed; `text` formats it.
async fn follow<T: PartialEq>(
    hosted: &Hosted,
    rate: f64,
    writer: &Writer,
    look: impl Fn() -> Option<(T, u64)>,
    text: impl Fn(&T) -> String,
) {
    let mut ticks = interval(Duration::from_secs_f64(1.0 / rate));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut last = None;
    loop {
        tokio::select! {
            _ = ticks.tick() => {}
            () = writer.closed() => return,
            () = hosted.gone.raised() => {
                let why = json!(StreamEnd { why: "the component was unloaded".to_owned() }).to_string();
                writer.send(Event::default().event("end").data(why)).await;
                return;
            }
        }
        let Some((value, date)) = look() else { continue };
        if last.as_ref() == Some(&value) {
            continue;
        }
        let event = Event::default().event("value").id(date.to_string());
        if !writer.send(event.data(text(&value))).await {
            return;
        }
        last = Some(value);
    }
}
