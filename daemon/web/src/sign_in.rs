//! Signing in and out.

use std::time::{Duration, Instant};

use axum::Json;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use genom_doors::{Holder, RpcError};
use genom_protocol::{Code, Right};
use http_body_util::BodyExt as _;
use serde::{Deserialize, Serialize};
use tokio::time::timeout;

use crate::console::Console;
use crate::gate::session;
use crate::secret::Secret;
use crate::visitor::Visitor;

/// Bytes of a request to sign in.
const LARGEST: usize = 4096;
/// Bytes that are read of a longer one.
const MOST_READ: usize = 1 << 20;
/// Time in which it has to come.
const SLOWEST: Duration = Duration::from_secs(10);

/// How somebody signs in.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
enum SignIn {
    /// With the one-time token of a link.
    Link(String),
    /// With a token of the token file.
    Token(String),
}

/// The session of a browser.
#[derive(Serialize)]
struct Signed {
    /// Its name in the log.
    who: String,
    /// What it may do.
    rights: Vec<Right>,
    /// Version of the daemon.
    genomd: &'static str,
    /// What distinguishes this console from others, for what a page keeps in the browser.
    console: String,
}

fn signed(console: &Console, holder: Holder) -> Json<Signed> {
    let genomd = env!("CARGO_PKG_VERSION");
    let console = console.cookie().to_owned();
    Json(Signed { who: holder.who, rights: holder.rights, genomd, console })
}

/// The body, if it is short. The rest of a longer one is read, too, up to a limit: closing a
/// connection with unread bytes resets it, and the peer may then lose the reply.
async fn read(mut body: Body) -> Option<Vec<u8>> {
    let (mut bytes, mut length) = (Vec::new(), 0);
    while let Some(frame) = body.frame().await {
        let frame = frame.ok()?;
        let data = frame.data_ref()?;
        length += data.len();
        if length > MOST_READ {
            return None;
        }
        if length <= LARGEST {
            bytes.extend_from_slice(data);
        }
    }
    (length <= LARGEST).then_some(bytes)
}

/// Tells whose session it is.
pub(crate) async fn look(
    State(console): State<Console>,
    headers: HeaderMap,
) -> Result<Response, RpcError> {
    let (_, holder) = session(&console, &headers).ok_or_else(|| {
        RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, "nobody is signed in here")
            .help("`genomctl web` prints a link that signs in")
    })?;
    Ok(signed(&console, holder).into_response())
}

/// Opens a session.
pub(crate) async fn open(
    State(console): State<Console>,
    request: Request,
) -> Result<Response, RpcError> {
    let (parts, body) = request.into_parts();
    let bytes = timeout(SLOWEST, read(body)).await.ok().flatten();
    let asked = bytes.and_then(|bytes| serde_json::from_slice::<SignIn>(&bytes).ok());
    let asked = asked.ok_or_else(|| {
        RpcError::bad_input("sign in with {\"link\": \"...\"} or {\"token\": \"...\"}")
    })?;
    let request = Request::from_parts(parts, Body::empty());
    let visitor = match &asked {
        SignIn::Link(secret) => console.links().open(secret, Instant::now()).ok_or_else(|| {
            console.refuse(&request, "a link that was used already or is too old");
            let message = "this link was used already, or is too old";
            RpcError::new(StatusCode::UNAUTHORIZED, Code::LinkOver, message)
                .help("`genomctl web` prints a new one")
        })?,
        SignIn::Token(token) => {
            let holder = console.tokens().holder(token.trim().as_bytes()).ok_or_else(|| {
                console.refuse(&request, "an unknown token");
                let message = "this token is not known here";
                RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, message).help(
                    "the file at rpc.token_file of the daemon's configuration lists the known ones",
                )
            })?;
            Visitor::of(&holder, None, console.tokens())
        }
    };
    let opened = console.sessions().open(visitor);
    let (secret, name) = opened.map_err(|error| RpcError::internal(error.to_string()))?;
    tracing::info!("{name} began");
    let holder = console.holder(&Secret(secret.clone()));
    let holder = holder.ok_or_else(|| RpcError::internal("the session is over already"))?;
    let cookie = console.set_cookie(&secret, console.sessions().lifetime().as_secs());
    Ok(([(header::SET_COOKIE, cookie)], signed(&console, holder)).into_response())
}

/// Ends the session.
pub(crate) async fn close(State(console): State<Console>, headers: HeaderMap) -> Response {
    if let Some((Secret(secret), _)) = session(&console, &headers) {
        console.sessions().close(&secret);
    }
    (StatusCode::NO_CONTENT, [(header::SET_COOKIE, console.set_cookie("", 0))]).into_response()
}
