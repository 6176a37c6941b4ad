//! Who may do what: rights, and the doors that requests come through.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_configuration::Right;
use genom_protocol::Code;

use crate::rpc::error::RpcError;
use crate::rpc::guests::{Guest, Held};
use crate::rpc::holder::Holder;
use crate::rpc::seldom::Seldom;
use crate::rpc::stream;
use crate::rpc::tokens::Tokens;
use crate::slots::Full;

/// Where requests come in.
#[derive(Clone, Debug)]
pub(crate) enum Door {
    /// The Unix socket, which only the daemon's own user can open: no token, all rights.
    Own,
    /// Any other: a token says who it is, or a client certificate, which TLS has checked.
    Guarded {
        tokens: Arc<Tokens>,
        log: Arc<Log>,
        /// Rights of those who come with a certificate; without a token they have these.
        certified: Vec<Right>,
    },
    /// A middleware: who it is was proved before the request came here.
    Proved { log: Arc<Log> },
}

/// What is told of those who come in by other doors than the socket.
#[derive(Debug, Default)]
pub(crate) struct Log {
    refused: Seldom,
    changes: Seldom,
}

/// Where a request comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) SocketAddr);

impl Door {
    fn holder(&self, request: &Request) -> Result<Holder, RpcError> {
        let (tokens, certified) = match self {
            Door::Own => return Ok(Holder::own()),
            Door::Proved { .. } => {
                let holder = request.extensions().get::<Holder>().cloned();
                return holder.ok_or_else(|| unknown("nobody proved to hold a token"));
            }
            Door::Guarded { tokens, certified, .. } => (tokens, certified),
        };
        let Some(given) = request.headers().get(header::AUTHORIZATION) else {
            if !certified.is_empty() {
                let who = "the holder of a client certificate".to_owned();
                return Ok(Holder::of(who, certified.clone()));
            }
            return Err(unknown("a token is needed here")
                .help("send one as `Authorization: Bearer TOKEN`; genomctl has --token-file"));
        };
        let mut holder = tokens
            .holder(bearer(given.as_bytes()))
            .ok_or_else(|| unknown("this token is not known here").help(KNOWN))?;
        holder.rights.extend(certified);
        Ok(holder)
    }

    fn log(&self) -> Option<&Log> {
        match self {
            Door::Own => None,
            Door::Guarded { log, .. } | Door::Proved { log } => Some(log),
        }
    }
}

/// The token of such a header; names of schemes are written in any case (RFC 9110, 11.1).
fn bearer(given: &[u8]) -> &[u8] {
    match given.split_at_checked(6) {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case(b"Bearer") => rest.trim_ascii_start(),
        _ => b"",
    }
}

impl Log {
    /// Somebody was refused: where from and why, never with what.
    fn refused(&self, request: &Request, why: &str) {
        let peer = request.extensions().get::<Peer>();
        let from = peer.map_or_else(String::new, |Peer(peer)| format!(" of {}", peer.ip()));
        let what = what(request);
        self.refused.tell(format!("{from}{why}"), |more| {
            tracing::warn!("refused {what}{from}: {why}{more}");
        });
    }

    /// Somebody changed something.
    fn changed(&self, who: &str, what: &str, status: StatusCode) {
        let outcome = if status.is_success() { "" } else { ", refused" };
        self.changes.tell(format!("{who} {what}{outcome}"), |more| {
            tracing::info!("{who}: {what}{outcome}{more}");
        });
    }
}

/// Method and path of a request, which are ASCII without blanks, as far as a line has room.
fn what(request: &Request) -> String {
    let path = request.uri().path();
    let short = path.get(..100).unwrap_or(path);
    format!("{} {short}", request.method())
}

const KNOWN: &str = "the file at rpc.token_file of the daemon's configuration lists the known ones";

fn unknown(message: &str) -> RpcError {
    RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, message)
}

/// The rights that the routes ask for, by path and method: `None` for what anybody may read.
pub(super) type Asked = BTreeMap<String, BTreeMap<&'static str, Option<Right>>>;

/// What stands before the handlers.
pub(super) struct Gate {
    pub(super) door: Door,
    pub(super) asked: Asked,
}

/// Lets through whoever has the right that the route asks for.
pub(super) async fn check(
    State(gate): State<Arc<Gate>>,
    mut request: Request,
    next: Next,
) -> Response {
    match admit(&gate, &request) {
        Ok(None) => next.run(request).await,
        Ok(Some(holder)) => {
            let changes = !matches!(*request.method(), Method::GET | Method::HEAD);
            let told = gate.door.log().filter(|_| changes);
            let told = told.map(|log| (log, holder.who.clone(), what(&request)));
            let busy = match request.extensions().get::<Guest>().map(|guest| guest.work(&holder)) {
                Some(Err(full)) => return too_busy(full).into_response(),
                Some(Ok(busy)) => Some(busy),
                None => None,
            };
            request.extensions_mut().insert(holder);
            let response = next.run(request).await;
            if let Some((log, who, what)) = told {
                log.changed(&who, &what, response.status());
            }
            // As long as the answer is under way: it may be a stream.
            response.map(|body| Body::new(Held::new(body, busy)))
        }
        Err(refused) => {
            if let Some(log) = gate.door.log() {
                log.refused(&request, refused.message());
            }
            let unknown = refused.status() == StatusCode::UNAUTHORIZED;
            let mut response = refused.into_response();
            if unknown {
                let scheme = HeaderValue::from_static("Bearer");
                response.headers_mut().insert(header::WWW_AUTHENTICATE, scheme);
            }
            response
        }
    }
}

fn too_busy(full: Full) -> RpcError {
    let message = format!("{} are under way already", stream::limit(full));
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyRequests, message)
        .help("wait for one to be answered, or raise rpc.max_connections_per_token")
}

fn admit(gate: &Gate, request: &Request) -> Result<Option<Holder>, RpcError> {
    let method = match request.method() {
        &Method::HEAD => "GET",
        method => method.as_str(),
    };
    let path = request.extensions().get::<MatchedPath>().map(MatchedPath::as_str);
    let asked = path.and_then(|path| gate.asked.get(path)?.get(method));
    if let Some(None) = asked {
        return Ok(None);
    }
    let holder = gate.door.holder(request)?;
    // Of no known path, nothing but that is told, and only to those who have a token.
    if let Some(Some(right)) = asked {
        holder.may(*right, format_args!("{method} {}", request.uri().path()))?;
    }
    Ok(Some(holder))
}
