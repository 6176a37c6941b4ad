//! Other daemons, on middlewares that relay requests, so that a fleet can be supervised from one
//! daemon and robots need no open TCP port.
//!
//! Messages between a client and another daemon are sealed (`genom_proof`): this daemon relays
//! messages and answers without being able to read them.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use genom_doors::{Holder, Parameters, RpcError};
use genom_middleware::{AskError, Middleware, Relay};
use genom_protocol::{Answered, Answers, AskParameters, Code, Daemons, VisibleDaemon};
use genom_registry::Backends;

use crate::daemon::Daemon;

/// How long all daemons of a name may take to answer a hello.
const HELLO: Duration = Duration::from_secs(3);

/// How long a daemon may take to answer a question.
const ANSWER: Duration = Duration::from_secs(60);

/// The same for requests that wait for something.
const WAIT: Duration = Duration::from_secs(3700);

/// List the daemons that are visible on middlewares.
///
/// A name is not authenticated: anybody may use any name. With `genomctl --host zenoh:NAME` the
/// daemon has to prove that it holds the token, which is never sent.
#[utoipa::path(
    get,
    path = "/daemons",
    tag = "daemon",
    responses((status = 200, body = Daemons))
)]
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Daemons> {
    let mut daemons = Vec::new();
    for (backend, open) in relays(&daemon.supervisor.backends) {
        match open.relay().map(|relay| relay.daemons()) {
            Some(Ok(names)) => {
                let visible = |name| VisibleDaemon { name, backend: backend.to_owned() };
                daemons.extend(names.into_iter().map(visible));
            }
            Some(Err(error)) => tracing::warn!("daemons on {backend}: {error}"),
            None => {}
        }
    }
    Json(Daemons { own: daemon.announcements.name(), daemons })
}

/// The open middlewares that relay requests.
fn relays(backends: &Backends) -> Vec<(&'static str, Arc<dyn Middleware>)> {
    let open = genom_registry::known().iter();
    let open = open.filter_map(|known| Some((known.name, backends.opened(known.name)?)));
    open.filter(|(_, open)| open.relay().is_some()).collect()
}

/// Send a hello to all daemons that answer to a name.
///
/// `docs/security.md` describes the messages, whose content this daemon does not process.
#[utoipa::path(
    post,
    path = "/daemons/{daemon}/hello",
    tag = "daemon",
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = Answers), (status = 404), (status = 409), (status = 502))
)]
pub(crate) async fn hello(
    State(daemon): State<Arc<Daemon>>,
    Extension(holder): Extension<Holder>,
    Path(name): Path<String>,
    message: Bytes,
) -> Result<Json<Answers>, RpcError> {
    let ask = move |relay: &dyn Relay, name: &str| relay.ask_all(name, &message, HELLO);
    let all = by_relay(&daemon, &holder, name, ask).await?;
    let answers = all.into_iter().map(|(at, bytes)| {
        // A message that is not text is no valid answer; the client will reject it.
        Answered { at, message: String::from_utf8(bytes).unwrap_or_default() }
    });
    Ok(Json(Answers { answers: answers.collect() }))
}

/// Send a sealed question to a daemon that answered a hello.
#[utoipa::path(
    post,
    path = "/daemons/{daemon}/questions",
    tag = "daemon",
    params(AskParameters),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 409), (status = 502), (status = 503)
    )
)]
pub(crate) async fn question(
    State(daemon): State<Arc<Daemon>>,
    Extension(holder): Extension<Holder>,
    Path(name): Path<String>,
    Parameters(parameters): Parameters<AskParameters>,
    message: Bytes,
) -> Result<Response, RpcError> {
    let AskParameters { at, wait } = parameters;
    let patience = if wait { WAIT } else { ANSWER };
    let ask = move |relay: &dyn Relay, name: &str| relay.ask(name, &at, &message, patience);
    let answer = by_relay(&daemon, &holder, name, ask).await?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], answer).into_response())
}

/// Of several, the first on which the daemon shows; if it shows on none, the first, which waits for
/// it a short time.
fn through<'a>(
    relays: &'a [(&'static str, Arc<dyn Middleware>)],
    name: &str,
) -> Option<&'a dyn Relay> {
    let mut all = relays.iter().filter_map(|(_, open)| open.relay());
    let shows =
        |relay: &&dyn Relay| relay.daemons().is_ok_and(|names| names.iter().any(|one| one == name));
    match relays {
        [_, _, ..] => all.clone().find(shows).or_else(|| all.next()),
        _ => all.next(),
    }
}

/// Sends a message by the middleware that relays requests. Takes a slot, because it may occupy a
/// thread for long.
async fn by_relay<T: Send + 'static>(
    daemon: &Daemon,
    holder: &Holder,
    name: String,
    ask: impl FnOnce(&dyn Relay, &str) -> Result<T, AskError> + Send + 'static,
) -> Result<T, RpcError> {
    let slot = daemon.questions.take(holder.share.clone()).map_err(|full| {
        let message = format!("{full} to other daemons are under way already");
        RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyQuestions, message)
            .help("wait for one to be answered")
    })?;
    let backends = Arc::clone(&daemon.supervisor.backends);
    let work = move || {
        let _slot = slot;
        let relays = relays(&backends);
        let Some(relay) = through(&relays, &name) else {
            let message = "this daemon is on no middleware that passes requests on";
            return Err(RpcError::conflict(Code::NoRelay, message)
                .help("start it with `--backend zenoh`, or load a component there"));
        };
        ask(relay, &name).map_err(|error| {
            let message = error.to_string();
            match error {
                AskError::Unknown { .. } => {
                    let visible = relay.daemons().unwrap_or_default();
                    let names = visible.iter().map(String::as_str);
                    RpcError::unknown(Code::NoSuchDaemon, "no daemon", &name, names)
                }
                _ => RpcError::new(StatusCode::BAD_GATEWAY, Code::DaemonSilent, message),
            }
        })
    };
    tokio::task::spawn_blocking(work)
        .await
        .map_err(|error| RpcError::internal(error.to_string()))?
}
