//! Authenticates requests and checks their rights.

use std::net::SocketAddr;
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_protocol::{Code, Right};

use crate::error::RpcError;
use crate::guests::{Guest, Held};
use crate::holder::Holder;
use crate::rights::{Rights, Wanted};
use crate::seldom::Seldom;
use crate::slots::Full;
use crate::tokens::Tokens;

/// Where requests come from, and how their senders are identified.
#[derive(Clone, Debug)]
pub struct Door(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Own,
    Guarded { tokens: Arc<Tokens>, log: Arc<Log>, certified: Vec<Right> },
    Proved { log: Arc<Log> },
}

/// The log of requests that do not come from the Unix socket.
#[derive(Debug, Default)]
pub struct Log {
    refused: Seldom,
    changes: Seldom,
}

/// Address of the sender of a request.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub SocketAddr);

impl Door {
    /// The Unix socket, which only the owner of the process can open: all rights, without a token.
    #[must_use]
    pub fn own() -> Self {
        Self(Kind::Own)
    }

    /// A network address. Senders are identified by a token, or by a client certificate that TLS
    /// has checked. `certified` are the rights of a certificate, to which those of a token are
    /// added; empty if TLS requires no certificates.
    #[must_use]
    pub fn guarded(tokens: Arc<Tokens>, log: Arc<Log>, certified: Vec<Right>) -> Self {
        Self(Kind::Guarded { tokens, log, certified })
    }

    /// Messages that others relay. The sender proved its identity before the request came here; a
    /// desk stores the holder in the request's extensions.
    #[must_use]
    pub fn proved(log: Arc<Log>) -> Self {
        Self(Kind::Proved { log })
    }

    /// Whether a request without a token is refused.
    pub(crate) fn asks_for_a_token(&self) -> bool {
        matches!(self.0, Kind::Guarded { .. })
    }

    fn holder(&self, request: &Request) -> Result<Holder, RpcError> {
        let (tokens, certified) = match &self.0 {
            Kind::Own => return Ok(Holder::own()),
            Kind::Proved { .. } => {
                let holder = request.extensions().get::<Holder>().cloned();
                return holder.ok_or_else(|| unknown("nobody proved to hold a token"));
            }
            Kind::Guarded { tokens, certified, .. } => (tokens, certified),
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
        match &self.0 {
            Kind::Own => None,
            Kind::Guarded { log, .. } | Kind::Proved { log } => Some(log),
        }
    }
}

/// The token of an `Authorization` header. The name of the scheme is case-insensitive (RFC 9110,
/// 11.1).
fn bearer(given: &[u8]) -> &[u8] {
    match given.split_at_checked(6) {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case(b"Bearer") => rest.trim_ascii_start(),
        _ => b"",
    }
}

impl Log {
    /// Logs a refused request: where it came from and why, but never the token.
    fn refused(&self, request: &Request, why: &str) {
        let peer = request.extensions().get::<Peer>();
        let from = peer.map_or_else(String::new, |Peer(peer)| format!(" of {}", peer.ip()));
        let what = what(request);
        self.refused.tell(format!("{from}{why}"), |more| {
            tracing::warn!("refused {what}{from}: {why}{more}");
        });
    }

    /// Logs a request that changed something.
    fn changed(&self, who: &str, what: &str, status: StatusCode) {
        let outcome = if status.is_success() { "" } else { ", refused" };
        self.changes.tell(format!("{who} {what}{outcome}"), |more| {
            tracing::info!("{who}: {what}{outcome}{more}");
        });
    }
}

/// Method and path of a request, which are ASCII without blanks, cut to the length of a log line.
fn what(request: &Request) -> String {
    let path = request.uri().path();
    let short = path.get(..100).unwrap_or(path);
    format!("{} {short}", request.method())
}

const KNOWN: &str = "the file at rpc.token_file of the daemon's configuration lists the known ones";

fn unknown(message: &str) -> RpcError {
    RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, message)
}

/// State of the check before the handlers.
pub(crate) struct Gate {
    pub(crate) door: Door,
    pub(crate) rights: Rights,
}

/// Passes on requests whose sender has the right that the route requires.
pub(crate) async fn check(
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
            // Held until the response, which may be a stream, has been sent.
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
    let message = format!("{full} are under way already");
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyRequests, message)
        .help("wait for one to be answered, or raise rpc.max_connections_per_token")
}

/// Path of the route that matches a request.
fn path(request: &Request) -> Option<&str> {
    request.extensions().get::<MatchedPath>().map(MatchedPath::as_str)
}

/// The method by which the table has it: a head is what GET would answer.
fn method(request: &Request) -> &str {
    match request.method() {
        &Method::HEAD => "GET",
        method => method.as_str(),
    }
}

/// The sender of a request; `None` if the route is open to anybody and the sender did not identify
/// itself.
fn admit(gate: &Gate, request: &Request) -> Result<Option<Holder>, RpcError> {
    let method = method(request);
    let wanted = gate.rights.wanted(method, path(request));
    if wanted == Wanted::Open {
        return Ok(None);
    }
    let holder = gate.door.holder(request)?;
    // An unknown path is reported only to clients with a token.
    match wanted {
        Wanted::Right(right) => {
            holder.may(right, format_args!("{method} {}", request.uri().path()))?;
        }
        // The method is refused by `refuse_method`, once the body is read.
        Wanted::NoSuchMethod | Wanted::NoSuchPath | Wanted::Open => {}
    }
    Ok(Some(holder))
}

/// Answers a method that the path of a route does not take, by the table: no handler is reached by
/// a way that has no right.
pub(crate) async fn refuse_method(
    State(gate): State<Arc<Gate>>,
    request: Request,
    next: Next,
) -> Response {
    let route = path(&request);
    if gate.rights.wanted(method(&request), route) != Wanted::NoSuchMethod {
        return next.run(request).await;
    }
    let message = format!("`{}` takes no {}", request.uri().path(), request.method());
    let refused = RpcError::new(StatusCode::METHOD_NOT_ALLOWED, Code::NoSuchMethod, message);
    let allowed = route.map(|route| gate.rights.allowed(route)).unwrap_or_default();
    ([(header::ALLOW, allowed)], refused).into_response()
}
