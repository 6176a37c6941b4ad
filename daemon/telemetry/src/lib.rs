//! What a daemon tells monitoring systems: spans of services to an OpenTelemetry collector (OTLP
//! over HTTP, in JSON), pages of metrics for Prometheus ([`Page`]), and the log ([`logs`]).
//!
//! A layer of `tracing` converts each span to OTLP when it closes, and queues it; a task posts the
//! queue. Nothing waits for the collector: spans that do not fit in the queue are dropped and
//! counted. There is no TLS: the collector has to be on this machine or on a trusted network.

#![forbid(unsafe_code)]

mod component;
pub mod logs;
mod page;
pub mod selection;
mod told;

pub use component::{COUNTER, GAUGE, count, describe};
pub use page::Page;
pub use told::tell_middlewares;

use std::collections::VecDeque;
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use axum::body::{Body, to_bytes};
use axum::http::{Request, StatusCode, Uri, header};
use genom_configuration::NoCollector;
use genom_supervisor::flag::Flag;
use genom_supervisor::spans::TARGET;
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use serde_json::{Map, Value, json};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Metadata, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;

/// Maximum number of queued spans.
const MOST: usize = 4096;
/// Maximum number of spans in one request.
const BATCH: usize = 512;
/// Timeout of a request to the collector.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long sending the last spans may take after the daemon stopped.
const LAST: Duration = Duration::from_secs(1);

/// The queue; there is one per process.
static QUEUE: LazyLock<Queue> = LazyLock::new(Queue::default);

#[derive(Default)]
struct Queue {
    waiting: Mutex<(VecDeque<Value>, u64)>,
    bell: Notify,
}

impl Queue {
    fn put(&self, span: Value) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        let (spans, lost) = &mut *waiting;
        if spans.len() < MOST {
            spans.push_back(span);
        } else {
            *lost += 1;
        }
        drop(waiting);
        self.bell.notify_one();
    }

    /// Takes the oldest spans, and the number of spans dropped since the last call.
    fn take(&self) -> (Vec<Value>, u64) {
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        let (spans, lost) = &mut *waiting;
        let count = spans.len().min(BATCH);
        (spans.drain(..count).collect(), std::mem::take(lost))
    }
}

/// Whether a span is to be exported.
pub fn is_ours(about: &Metadata<'_>) -> bool {
    about.is_span() && about.target() == TARGET
}

/// Address of a collector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Collector {
    /// `host:port`
    authority: String,
    path: String,
}

impl Collector {
    /// Parses `http://HOST:PORT`, with or without a path.
    pub fn parse(text: &str) -> Result<Self, NoCollector> {
        let text = || text.to_owned();
        let uri: Uri = text().parse().map_err(|_| NoCollector::NoUrl(text()))?;
        if uri.scheme_str() != Some("http") {
            return Err(NoCollector::NotHttp(text()));
        }
        let authority = uri.authority().ok_or_else(|| NoCollector::NoHost(text()))?;
        let port = authority.port_u16().unwrap_or(4318);
        let path = match uri.path() {
            "" | "/" => "/v1/traces",
            path => path,
        };
        Ok(Self { authority: format!("{}:{port}", authority.host()), path: path.to_owned() })
    }
}

/// Queues spans when they close.
pub struct Exported;

/// The fields of a span so far.
struct Told {
    start: u128,
    words: Words,
}

#[derive(Default)]
struct Words(Map<String, Value>);

impl Visit for Words {
    fn record_u64(&mut self, field: &Field, value: u64) {
        // 64-bit integers are strings in the JSON of OTLP.
        self.0.insert(field.name().to_owned(), json!({"intValue": value.to_string()}));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.0.insert(field.name().to_owned(), json!({ "stringValue": value }));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        self.record_str(field, &format!("{value:?}"));
    }
}

impl Words {
    fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key)?["stringValue"].as_str()
    }
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for Exported {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut words = Words::default();
        attributes.record(&mut words);
        span.extensions_mut().insert(Told { start: now(), words });
    }

    fn on_record(&self, id: &Id, values: &Record<'_>, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        if let Some(told) = span.extensions_mut().get_mut::<Told>() {
            values.record(&mut told.words);
        }
    }

    fn on_close(&self, id: Id, context: Context<'_, S>) {
        let Some(told) = context.span(&id).and_then(|span| span.extensions_mut().remove()) else {
            return;
        };
        QUEUE.put(otlp(&told, now()));
    }
}

/// Converts a span to OTLP.
fn otlp(told: &Told, end: u128) -> Value {
    let Told { start, words } = told;
    let word = |key| words.text(key).unwrap_or_default();
    let attributes: Vec<Value> = words
        .0
        .iter()
        .map(|(key, value)| json!({"key": format!("genom.{key}"), "value": value}))
        .collect();
    let status = match words.text("exception") {
        Some(exception) => json!({"code": 2, "message": exception}),
        None => json!({"code": 1}),
    };
    json!({
        "traceId": format!("{:016x}{:016x}", random(), random()),
        "spanId": format!("{:016x}", random()),
        "name": format!("{}/{}", word("component"), word("service")),
        // `SPAN_KIND_SERVER`.
        "kind": 2,
        "startTimeUnixNano": start.to_string(),
        "endTimeUnixNano": end.to_string(),
        "attributes": attributes,
        "status": status,
    })
}

fn now() -> u128 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos()
}

/// Never 0, which OTLP does not allow as an identifier.
fn random() -> u64 {
    RandomState::new().build_hasher().finish().max(1)
}

/// Posts queued spans until `closed` is raised, then the remaining ones.
pub async fn export(collector: Collector, daemon: Option<String>, closed: Flag) {
    let mut refused = false;
    loop {
        let ends = closed.is_up();
        let (spans, lost) = QUEUE.take();
        if lost > 0 {
            tracing::warn!("{lost} spans were lost: the collector does not keep up");
        }
        if !spans.is_empty() {
            let patience = if ends { LAST } else { PATIENCE };
            let posted = tokio::time::timeout(patience, post(&collector, spans, daemon.as_deref()));
            let outcome = posted.await.unwrap_or(Err(ExportError::Silent));
            if let Err(why) = &outcome
                && !refused
            {
                let Collector { authority, path } = &collector;
                tracing::warn!("spans are not taken by http://{authority}{path}: {why}");
            }
            refused = outcome.is_err();
            if !(ends && refused) {
                continue;
            }
        }
        if ends {
            return;
        }
        tokio::select! {
            () = QUEUE.bell.notified() => {}
            () = closed.raised() => {}
        }
    }
}

/// Why spans could not be sent to the collector.
#[derive(Debug, thiserror::Error)]
enum ExportError {
    #[error(transparent)]
    Connect(#[from] std::io::Error),
    #[error(transparent)]
    Talk(#[from] hyper::Error),
    #[error(transparent)]
    Request(#[from] axum::http::Error),
    #[error("status {0}")]
    Refused(StatusCode),
    #[error("no answer")]
    Silent,
}

async fn post(
    collector: &Collector,
    spans: Vec<Value>,
    daemon: Option<&str>,
) -> Result<(), ExportError> {
    let text = |key: &str, value: &str| json!({"key": key, "value": {"stringValue": value}});
    let version = env!("CARGO_PKG_VERSION");
    let mut resource = vec![text("service.name", "genomd"), text("service.version", version)];
    resource.extend(daemon.map(|name| text("service.instance.id", name)));
    let body = json!({"resourceSpans": [{
        "resource": {"attributes": resource},
        "scopeSpans": [{"scope": {"name": "genomd", "version": version}, "spans": spans}],
    }]});
    let stream = TcpStream::connect(&collector.authority).await?;
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await?;
    tokio::spawn(connection);
    let request = Request::post(&collector.path)
        .header(header::HOST, &collector.authority)
        .header(header::CONTENT_TYPE, "application/json")
        .header(header::CONNECTION, "close")
        .body(Body::from(body.to_string()))?;
    let response = sender.send_request(request).await?;
    let status = response.status();
    let _ = to_bytes(Body::new(response.into_body()), 1 << 16).await;
    if status.is_success() { Ok(()) } else { Err(ExportError::Refused(status)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collector_is_an_http_url() {
        let read = |text| Collector::parse(text).map(|one| (one.authority, one.path));
        let usual = ("127.0.0.1:4318".to_owned(), "/v1/traces".to_owned());
        assert_eq!(read("http://127.0.0.1"), Ok(usual.clone()));
        assert_eq!(read("http://127.0.0.1:4318/"), Ok(usual));
        let other = ("[::1]:9".to_owned(), "/otlp".to_owned());
        assert_eq!(read("http://[::1]:9/otlp"), Ok(other));
        for wrong in ["https://a", "127.0.0.1:4318", "", "http://"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
