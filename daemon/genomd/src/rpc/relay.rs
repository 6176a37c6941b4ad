//! Requests to and from other daemons, through middlewares that pass them on: a fleet is
//! supervised from one daemon, and no robot opens a TCP port.
//!
//! A request with the header `Genomd-Daemon: NAME` goes to that daemon, with its token, and is
//! answered there as if it had come by TCP. Streams are not passed on.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::{Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_middleware::{AskError, Middleware};
use hyper::service::Service as _;
use hyper_util::service::TowerToHyperService;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::daemon::Daemon;
use crate::registry;
use crate::rpc::access::Door;
use crate::rpc::error::RpcError;
use crate::rpc::tokens::Tokens;

/// Names the daemon that a request is meant for.
pub(super) const HEADER: &str = "genomd-daemon";

/// How long another daemon may take to answer.
const ANSWER: Duration = Duration::from_secs(60);

/// The same for requests that wait for something.
const WAIT: Duration = Duration::from_secs(3700);

/// Greatest answer that is passed on.
const MOST: usize = 16 << 20;

/// A request on its way.
#[derive(Debug, Deserialize, Serialize)]
struct Passed {
    method: String,
    /// Path and query.
    path: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    authorization: Option<String>,
    body: String,
}

/// Its answer.
#[derive(Debug, Deserialize, Serialize)]
struct Answered {
    status: u16,
    content_type: String,
    body: String,
}

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
    request: Request,
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

async fn ask(daemon: Arc<Daemon>, name: String, request: Request) -> Result<Response, RpcError> {
    let (parts, body) = request.into_parts();
    let body = to_bytes(body, daemon.settings.rpc.max_body);
    let body = body.await.map_err(|_| RpcError::too_large())?;
    let path = parts.uri.path_and_query().map_or("/", |path| path.as_str()).to_owned();
    let waits = path.contains("wait=") || path == "/deployment";
    let authorization = parts.headers.get(header::AUTHORIZATION);
    let passed = Passed {
        method: parts.method.to_string(),
        path,
        authorization: authorization.and_then(|given| given.to_str().ok()).map(str::to_owned),
        body: String::from_utf8_lossy(&body).into_owned(),
    };
    let bytes =
        serde_json::to_vec(&passed).map_err(|error| RpcError::internal(error.to_string()))?;
    let work = move || {
        let relays = relays(&daemon);
        let Some(relay) = relays.iter().find_map(|(_, open)| open.relay()) else {
            let message = "this daemon is on no middleware that passes requests on";
            return Err(RpcError::conflict("no_relay", message)
                .help("start it with `--backend zenoh`, or load a component there"));
        };
        let answer = relay.ask(&name, &bytes, if waits { WAIT } else { ANSWER });
        answer.map_err(|error| {
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
    let answer: Answered = serde_json::from_slice(&answer).map_err(|error| {
        let message = format!("the other daemon's answer is not understood: {error}");
        RpcError::new(StatusCode::BAD_GATEWAY, "daemon_silent", message)
    })?;
    let mut response = Response::new(Body::from(answer.body));
    *response.status_mut() = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::BAD_GATEWAY);
    if let Ok(kind) = HeaderValue::from_str(&answer.content_type) {
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
    }
    Ok(response)
}

/// Shows this daemon on a middleware that passes requests on, and answers those to it.
pub(crate) fn announce(
    daemon: &Arc<Daemon>,
    tokens: &Arc<Tokens>,
    runtime: &tokio::runtime::Handle,
    middleware: &dyn Middleware,
) {
    let Some(relay) = middleware.relay() else { return };
    // Whoever comes this way may be anybody on the network: the tokens say who.
    let door = Door::Guarded { tokens: Arc::clone(tokens), certified: Vec::new() };
    let router = super::router(Arc::clone(daemon), door);
    for name in names(daemon) {
        let (router, runtime) = (router.clone(), runtime.clone());
        let requests = move |bytes: Vec<u8>, answer: Box<dyn FnOnce(Vec<u8>) + Send>| {
            let router = router.clone();
            runtime.spawn(async move {
                let answered = reply(router, &bytes).await;
                answer(serde_json::to_vec(&answered).unwrap_or_default());
            });
        };
        match relay.announce(&name, Box::new(requests)) {
            Ok(shown) => return daemon.shown.keep(name, shown),
            // Another daemon has that name: the next one is this daemon's alone.
            Err(error) => tracing::warn!("{name} on {}: {error}", middleware.name()),
        }
    }
}

/// What this daemon may be called: as it was started, else by its machine.
fn names(daemon: &Daemon) -> Vec<String> {
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let name = daemon.settings.name.clone().unwrap_or_else(|| host.trim().to_owned());
    let name = if name.is_empty() { "genomd".to_owned() } else { name };
    vec![name.clone(), format!("{name}-{}", std::process::id())]
}

async fn reply(router: Router, bytes: &[u8]) -> Answered {
    let refused = |message: &str| RpcError::new(StatusCode::BAD_REQUEST, "malformed", message);
    let response = match serde_json::from_slice::<Passed>(bytes) {
        Err(error) => refused(&error.to_string()).into_response(),
        Ok(passed) => {
            let mut request = Request::builder().method(passed.method.as_str()).uri(passed.path);
            if let Some(authorization) = passed.authorization {
                request = request.header(header::AUTHORIZATION, authorization);
            }
            match request.body(Body::from(passed.body)) {
                Err(error) => refused(&error.to_string()).into_response(),
                Ok(request) => match TowerToHyperService::new(router).call(request).await {
                    Ok(response) => response,
                    Err(never) => match never {},
                },
            }
        }
    };
    let kind = response.headers().get(header::CONTENT_TYPE);
    let content_type = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default().to_owned();
    let response = if content_type.starts_with("text/event-stream") {
        let message = "streams are not passed on between daemons";
        RpcError::new(StatusCode::NOT_IMPLEMENTED, "no_stream", message)
            .help("ask for values instead, or reach the daemon by TCP")
            .into_response()
    } else {
        response
    };
    let status = response.status().as_u16();
    match to_bytes(response.into_body(), MOST).await {
        Ok(body) => {
            Answered { status, content_type, body: String::from_utf8_lossy(&body).into_owned() }
        }
        Err(error) => Answered {
            status: StatusCode::BAD_GATEWAY.as_u16(),
            content_type: "text/plain".to_owned(),
            body: error.to_string(),
        },
    }
}
