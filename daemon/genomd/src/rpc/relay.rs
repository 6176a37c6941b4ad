//! Requests to and from other daemons, through middlewares that pass them on: a fleet is
//! supervised from one daemon, and no robot opens a TCP port.
//!
//! A request with the header `Genomd-Daemon: NAME` goes to that daemon, with its token, and is
//! answered there as if it had come by TCP. A reply without an end, such as server-sent events, is
//! fetched piece by piece (`streams`).

mod message;
mod streams;

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::State;
use axum::http::{HeaderValue, Request, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_middleware::{AnnounceError, AskError, Middleware};
use hyper::body::Body as _;
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use serde::Serialize;
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::ReceiverStream;
use utoipa::ToSchema;

use self::message::{Answer, Question};
use self::streams::Streams;
use crate::daemon::Daemon;
use crate::registry;
use crate::rpc::error::RpcError;
use crate::rpc::stream;

/// Names the daemon that a request is meant for.
pub(super) const HEADER: &str = "genomd-daemon";

/// How long another daemon may take to answer.
const ANSWER: Duration = Duration::from_secs(60);

/// The same for requests that wait for something.
const WAIT: Duration = Duration::from_secs(3700);

/// Greatest answer that is passed on.
const MOST: usize = 16 << 20;

/// A reader that takes nothing of a stream for so long is given up.
const SLOWEST_READER: Duration = Duration::from_secs(10);

/// Pieces of a stream that wait for the reader.
const WAITING: usize = 4;

/// Daemons that are visible.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Daemons {
    /// Name of this one, where it is visible.
    own: Option<String>,
    daemons: Vec<Visible>,
}

/// A daemon on a middleware.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Visible {
    name: String,
    /// The middleware.
    backend: &'static str,
}

/// List the daemons that are visible on middlewares.
///
/// A request with the header `Genomd-Daemon: NAME` is passed on to that one.
#[utoipa::path(
    get,
    path = "/daemons",
    tag = "daemon",
    security(("token" = ["read"])),
    responses((status = 200, body = Daemons))
)]
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Daemons> {
    let mut daemons = Vec::new();
    for (backend, open) in relays(&daemon) {
        match open.relay().map(|relay| relay.daemons()) {
            Some(Ok(names)) => {
                daemons.extend(names.into_iter().map(|name| Visible { name, backend }));
            }
            Some(Err(error)) => tracing::warn!("daemons on {backend}: {error}"),
            None => {}
        }
    }
    Json(Daemons { own: daemon.shown.name(), daemons })
}

fn relays(daemon: &Daemon) -> Vec<(&'static str, Arc<dyn Middleware>)> {
    let open = registry::known().iter();
    let open = open.filter_map(|known| Some((known.name, daemon.backends.opened(known.name)?)));
    open.filter(|(_, open)| open.relay().is_some()).collect()
}

/// Passes on what is meant for another daemon.
pub(super) async fn pass_on(
    State(daemon): State<Arc<Daemon>>,
    request: Request<Body>,
    next: Next,
) -> Response {
    let Some(name) = request.headers().get(HEADER) else { return next.run(request).await };
    let Ok(name) = name.to_str().map(str::to_owned) else {
        return RpcError::new(StatusCode::BAD_REQUEST, "bad_header", "Genomd-Daemon: no name")
            .into_response();
    };
    match ask(daemon, name, request).await {
        Ok(response) => response,
        Err(error) => error.into_response(),
    }
}

async fn ask(
    daemon: Arc<Daemon>,
    name: String,
    request: Request<Body>,
) -> Result<Response, RpcError> {
    let (parts, body) = request.into_parts();
    let body = to_bytes(body, daemon.settings.rpc.max_body);
    let body = body.await.map_err(|_| RpcError::too_large())?;
    let path = parts.uri.path_and_query().map_or("/", |path| path.as_str()).to_owned();
    let waits = path.contains("wait=") || path == "/deployment";
    let given = |key| {
        let value = parts.headers.get(key).and_then(|given: &HeaderValue| given.to_str().ok());
        value.map(str::to_owned)
    };
    let question = Question::Request(message::Request {
        method: parts.method.to_string(),
        path,
        authorization: given("authorization"),
        last_event_id: given("last-event-id"),
    });
    let patience = if waits { WAIT } else { ANSWER };
    let (answer, body) = question_to(&daemon, &name, &question, &body, patience).await?;
    let body = match answer.stream {
        None => Body::from(body),
        Some(stream) => {
            let slot = stream::slot(&daemon)?;
            let (sender, pieces) = mpsc::channel(WAITING);
            tokio::spawn(fetch(daemon, name, stream, sender, slot));
            Body::from_stream(ReceiverStream::new(pieces).map(Ok::<_, Infallible>))
        }
    };
    let mut response = Response::new(body);
    *response.status_mut() = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::BAD_GATEWAY);
    if let Ok(kind) = HeaderValue::from_str(&answer.content_type) {
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
    }
    Ok(response)
}

/// Asks another daemon.
async fn question_to(
    daemon: &Arc<Daemon>,
    name: &str,
    question: &Question,
    body: &[u8],
    patience: Duration,
) -> Result<(Answer, Vec<u8>), RpcError> {
    let bytes = message::encode(question, body);
    let (daemon, name) = (Arc::clone(daemon), name.to_owned());
    let work = move || {
        let relays = relays(&daemon);
        let Some(relay) = relays.iter().find_map(|(_, open)| open.relay()) else {
            let message = "this daemon is on no middleware that passes requests on";
            return Err(RpcError::conflict("no_relay", message)
                .help("start it with `--backend zenoh`, or load a component there"));
        };
        relay.ask(&name, &bytes, patience).map_err(|error| {
            let message = error.to_string();
            match error {
                AskError::Unknown { .. } => {
                    let shown = relay.daemons().unwrap_or_default();
                    let names = shown.iter().map(String::as_str);
                    RpcError::unknown("no_such_daemon", "no daemon", &name, names)
                }
                _ => RpcError::new(StatusCode::BAD_GATEWAY, "daemon_silent", message),
            }
        })
    };
    let answer = tokio::task::spawn_blocking(work)
        .await
        .map_err(|error| RpcError::internal(error.to_string()))??;
    let (answer, body) = message::decode(&answer).map_err(|error| {
        let message = format!("the other daemon's answer is not understood: {error}");
        RpcError::new(StatusCode::BAD_GATEWAY, "daemon_silent", message)
    })?;
    Ok((answer, body.to_vec()))
}

/// Fetches a stream of another daemon's for a reader here, as long as both are there.
async fn fetch(
    daemon: Arc<Daemon>,
    name: String,
    stream: String,
    reader: mpsc::Sender<Bytes>,
    _slot: OwnedSemaphorePermit,
) {
    let more = Question::More(stream.clone());
    loop {
        let answer = tokio::select! {
            () = daemon.closed.raised() => return,
            () = reader.closed() => break,
            answer = question_to(&daemon, &name, &more, &[], ANSWER) => answer,
        };
        let Ok((answer, piece)) = answer else { return };
        let sent = piece.is_empty()
            || reader.send_timeout(Bytes::from(piece), SLOWEST_READER).await.is_ok();
        if answer.stream.is_none() {
            return;
        }
        if !sent {
            break;
        }
    }
    // Should that get lost, the other daemon closes it when nobody has asked for some time.
    let _ = question_to(&daemon, &name, &Question::End(stream), &[], ANSWER).await;
}

/// Shows this daemon on a middleware that passes requests on, and answers those to it by `router`.
pub(crate) fn announce(
    daemon: &Arc<Daemon>,
    router: &Router,
    runtime: &tokio::runtime::Handle,
    middleware: &dyn Middleware,
) {
    let Some(relay) = middleware.relay() else { return };
    let streams = Arc::new(Streams::default());
    let mut refused = None;
    for name in names(daemon) {
        let (router, runtime) = (router.clone(), runtime.clone());
        let streams = Arc::clone(&streams);
        let requests = move |bytes: Vec<u8>, answer: Box<dyn FnOnce(Vec<u8>) + Send>| {
            let (router, streams) = (router.clone(), Arc::clone(&streams));
            runtime.spawn(async move {
                let (head, body) = reply(router, &streams, &bytes).await;
                answer(message::encode(&head, &body));
            });
        };
        match relay.announce(&name, Box::new(requests)) {
            Ok(shown) => {
                if let Some(error) = refused {
                    tracing::warn!("{error}; this one is `{name}` there");
                }
                return daemon.shown.keep(name, shown);
            }
            // Another daemon has that name: the next one is this daemon's alone.
            Err(error @ AnnounceError::Taken { .. }) => refused = Some(error),
            Err(error) => return tracing::warn!("{error}"),
        }
    }
    if let Some(error) = refused {
        tracing::warn!("{error}; this one is not reachable there");
    }
}

/// What this daemon may be called: as it was started, else by its machine.
fn names(daemon: &Daemon) -> Vec<String> {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = daemon.settings.name.clone().unwrap_or_else(|| host.trim().to_owned());
    let name = if name.is_empty() { "genomd".to_owned() } else { name };
    vec![name.clone(), format!("{name}-{}", std::process::id())]
}

async fn reply(router: Router, streams: &Arc<Streams>, bytes: &[u8]) -> (Answer, Vec<u8>) {
    let refused = |why: String| RpcError::new(StatusCode::BAD_REQUEST, "malformed", why);
    let response = match message::decode(bytes) {
        Err(error) => refused(error.to_string()).into_response(),
        Ok((Question::More(stream), _)) => {
            let (piece, more) = streams.more(&stream).await;
            let stream = more.then_some(stream);
            return (Answer { status: 200, stream, ..Answer::default() }, piece);
        }
        Ok((Question::End(stream), _)) => {
            streams.end(&stream);
            return (Answer { status: 200, ..Answer::default() }, Vec::new());
        }
        Ok((Question::Request(passed), body)) => match request(passed, body) {
            Err(error) => refused(error.to_string()).into_response(),
            Ok(request) => match TowerToHyperService::new(router).call(request).await {
                Ok(response) => response,
                Err(never) => match never {},
            },
        },
    };
    let kind = response.headers().get(header::CONTENT_TYPE);
    let content_type = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default().to_owned();
    let status = response.status().as_u16();
    let failed = |why: String| {
        let content_type = "text/plain".to_owned();
        let status = StatusCode::BAD_GATEWAY.as_u16();
        (Answer { status, content_type, stream: None }, why.into_bytes())
    };
    let body = response.into_body();
    if body.size_hint().exact().is_none() {
        return match streams.add(body) {
            Ok(stream) => (Answer { status, content_type, stream: Some(stream) }, Vec::new()),
            Err(error) => failed(error.to_string()),
        };
    }
    match to_bytes(body, MOST).await {
        Ok(body) => (Answer { status, content_type, stream: None }, body.to_vec()),
        Err(error) => failed(error.to_string()),
    }
}

fn request(passed: message::Request, body: &[u8]) -> Result<Request<Body>, axum::http::Error> {
    let mut request = Request::builder().method(passed.method.as_str()).uri(passed.path);
    if let Some(authorization) = passed.authorization {
        request = request.header(header::AUTHORIZATION, authorization);
    }
    if let Some(number) = passed.last_event_id {
        request = request.header("last-event-id", number);
    }
    request.body(Body::from(body.to_vec()))
}
