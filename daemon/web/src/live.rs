//! The live stream of a page: one connection for all that the page shows.
//!
//! A page names paths of the control plane. Streams among them (changes, the log) are passed on;
//! the others are read several times a second, and sent if they differ from what was sent last.
//! They are read with the rights of the session, so that nothing can be watched that could not be
//! read. What no page watches is not read at all, and no task of a component takes part.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::time::Duration;

use axum::Extension;
use axum::body::{Body, Bytes};
use axum::extract::{Query, Request, State};
use axum::http::{Extensions, StatusCode};
use axum::response::Response;
use axum::response::sse::Event;
use genom_doors::{Events, Holder, RpcError, Writer};
use genom_protocol::Code;
use http_body_util::{BodyExt as _, Limited};
use serde_json::{Value, json};
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::{Instant, MissedTickBehavior, interval};

use crate::blocks::Blocks;
use crate::console::Console;
use crate::inside::Inside;
use crate::secret::Secret;

/// Paths that one page may watch.
const MOST: usize = 32;
/// Greatest number of readings in a second.
const FASTEST: f64 = 30.0;
/// Readings in a second, unless the page says otherwise.
const USUAL: f64 = 10.0;
/// Bytes of a reply that is watched; greater ones are not sent.
const LARGEST: usize = 2 << 20;

/// What a page watches.
struct Watched {
    path: String,
    /// Hash of what was sent last.
    sent: Option<u64>,
}

impl Watched {
    /// Whether the path is a stream of the control plane.
    fn is_stream(&self) -> bool {
        let path = self.path.split('?').next().unwrap_or_default();
        path == "/events" || path.ends_with("/stream") || path.ends_with("/plots")
    }
}

/// `?watch=PATH&watch=PATH&rate=HERTZ`
fn parse(query: Vec<(String, String)>) -> Result<(Vec<Watched>, f64), RpcError> {
    let (mut all, mut rate) = (Vec::new(), USUAL);
    for (key, value) in query {
        match key.as_str() {
            "watch" if value.starts_with('/') => all.push(Watched { path: value, sent: None }),
            "rate" => rate = value.parse().unwrap_or(f64::NAN),
            _ => {
                let message = format!("`{key}` is neither `rate` nor a path to `watch`");
                return Err(RpcError::new(StatusCode::BAD_REQUEST, Code::BadQuery, message));
            }
        }
    }
    if all.len() > MOST {
        let message = format!("{} paths to watch, {MOST} at most", all.len());
        return Err(RpcError::bad_input(message).place("watch"));
    }
    if !(rate > 0.0 && rate <= FASTEST) {
        let message = format!("rate: more than 0 and at most {FASTEST} readings a second");
        return Err(RpcError::bad_input(message).place("rate"));
    }
    Ok((all, rate))
}

/// Opens the stream of a page.
pub(crate) async fn open(
    State(console): State<Console>,
    Extension(inside): Extension<Inside>,
    Extension(holder): Extension<Holder>,
    Extension(secret): Extension<Secret>,
    Query(query): Query<Vec<(String, String)>>,
    request: Request,
) -> Result<Events, RpcError> {
    let (watched, rate) = parse(query)?;
    let extensions = request.extensions().clone();
    let streams = console.streams().clone();
    streams.open(&holder, move |writer| async move {
        let feed = Feed { console, inside, secret, writer, watched, extensions };
        feed.run(rate).await;
    })
}

struct Feed {
    console: Console,
    inside: Inside,
    secret: Secret,
    writer: Writer,
    watched: Vec<Watched>,
    /// Those of the page's request: they say who reads.
    extensions: Extensions,
}

impl Feed {
    async fn run(mut self, rate: f64) {
        let period = Duration::from_secs_f64(1.0 / rate);
        let mut ticks = interval(period);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let (sender, mut told) = mpsc::channel(64);
        let mut following = JoinSet::new();
        // Opened before anything is read: no change comes between.
        for (index, one) in self.watched.iter().enumerate().filter(|(_, one)| one.is_stream()) {
            let response = self.inside.read(&one.path, self.extensions.clone()).await;
            following.spawn(follow(response, index, sender.clone()));
        }
        let (mut before, mut skipped) = (Instant::now(), 0);
        loop {
            let goes_on = tokio::select! {
                now = ticks.tick() => {
                    let left_out = left_out(now.duration_since(before), period);
                    before = now;
                    skipped += left_out;
                    let tells = left_out == 0 || self.tell(&json!({"skipped": skipped})).await;
                    tells && self.read_all().await
                }
                Some(told) = told.recv() => self.tell(&told).await,
                () = self.writer.closed() => false,
            };
            if !goes_on {
                return;
            }
        }
    }

    async fn tell(&self, what: &Value) -> bool {
        self.writer.send(Event::default().data(what.to_string())).await
    }

    /// Reads everything that is no stream, and sends what changed.
    async fn read_all(&mut self) -> bool {
        if self.console.holder(&self.secret).is_none() {
            self.tell(&json!({"over": true})).await;
            return false;
        }
        for index in 0..self.watched.len() {
            let one = &self.watched[index];
            if one.is_stream() {
                continue;
            }
            let (status, body) = self.read(&one.path).await;
            let mut hasher = DefaultHasher::new();
            (status, &body).hash(&mut hasher);
            let hash = Some(hasher.finish());
            if hash == one.sent {
                continue;
            }
            self.watched[index].sent = hash;
            // The reply is JSON already.
            let body = String::from_utf8_lossy(&body);
            let text = format!("{{\"watch\":{index},\"status\":{status},\"body\":{body}}}");
            if !self.writer.send(Event::default().data(text)).await {
                return false;
            }
        }
        true
    }

    async fn read(&self, path: &str) -> (u16, Bytes) {
        let response = self.inside.read(path, self.extensions.clone()).await;
        let status = response.status().as_u16();
        match Limited::new(response.into_body(), LARGEST).collect().await {
            Ok(body) => {
                let body = body.to_bytes();
                let json = serde_json::from_slice::<serde::de::IgnoredAny>(&body).is_ok();
                (status, if json { body } else { Bytes::from_static(b"null") })
            }
            Err(_) => {
                let message = format!("more than {} MiB, too much to be watched", LARGEST >> 20);
                let body = json!({"error": {"code": Code::TooLarge.name(), "message": message}});
                (StatusCode::PAYLOAD_TOO_LARGE.as_u16(), body.to_string().into())
            }
        }
    }
}

/// How many readings were left out because the page did not take those before.
fn left_out(elapsed: Duration, period: Duration) -> u64 {
    let periods = (elapsed.as_secs_f64() / period.as_secs_f64()).round();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
    let periods = periods as u64;
    periods.saturating_sub(1)
}

/// Passes on a stream of the control plane, event by event. A page that takes them too slowly
/// delays the stream, which then says itself how many it left out.
async fn follow(response: Response, index: usize, to: mpsc::Sender<Value>) {
    let (status, mut body) = (response.status(), response.into_body());
    if status.is_success() {
        let mut blocks = Blocks::default();
        while let Some(Ok(frame)) = body.frame().await {
            let Some(bytes) = frame.data_ref() else { continue };
            for told in blocks.add(bytes) {
                let told =
                    json!({"watch": index, "id": told.id, "kind": told.kind, "told": told.data});
                if to.send(told).await.is_err() {
                    return;
                }
            }
        }
    }
    let error = match status.is_success() {
        true => Value::Null,
        false => refusal(body).await,
    };
    let status = status.as_u16();
    let _ = to.send(json!({"watch": index, "status": status, "ended": true, "error": error})).await;
}

/// Why a stream was refused.
async fn refusal(body: Body) -> Value {
    let bytes = Limited::new(body, LARGEST).collect().await.map(|body| body.to_bytes());
    let told = bytes.ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    told.and_then(|mut told| told.get_mut("error").map(Value::take)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(query: &[(&str, &str)]) -> Result<usize, RpcError> {
        let query = query.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        parse(query.collect()).map(|(watched, _)| watched.len())
    }

    #[test]
    fn a_page_watches_a_limited_number_of_paths_at_a_limited_rate() {
        assert_eq!(
            parsed(&[("watch", "/components"), ("watch", "/events"), ("rate", "30")]).unwrap(),
            2
        );
        assert!(parsed(&vec![("watch", "/"); MOST]).is_ok());
        assert!(parsed(&vec![("watch", "/"); MOST + 1]).is_err());
        for rate in ["0", "-1", "31", "NaN", "fast", "inf"] {
            assert!(parsed(&[("rate", rate)]).is_err(), "{rate}");
        }
        for (key, value) in [("watch", "components"), ("wach", "/"), ("watch", "http://x/")] {
            assert!(parsed(&[(key, value)]).is_err(), "{key}={value}");
        }
    }

    #[test]
    fn readings_that_were_left_out_are_counted() {
        let period = Duration::from_millis(100);
        for (elapsed, count) in [(0, 0), (100, 0), (149, 0), (200, 1), (1000, 9)] {
            assert_eq!(left_out(Duration::from_millis(elapsed), period), count, "{elapsed} ms");
        }
    }
}
