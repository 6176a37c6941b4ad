//! Who may do what: rights, and the doors that requests come through.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};

use crate::config::Right;
use crate::rpc::error::RpcError;
use crate::rpc::holder::Holder;
use crate::rpc::tokens::Tokens;

/// Where requests come in.
#[derive(Clone, Debug)]
pub(crate) enum Door {
    /// The Unix socket, which only the daemon's own user can open: no token, all rights.
    Own,
    /// Any other: a token says who it is, or a client certificate, which TLS has checked.
    Guarded {
        tokens: Arc<Tokens>,
        /// Rights of those who come with a certificate; without a token they have these.
        certified: Vec<Right>,
    },
}

impl Door {
    fn holder(&self, headers: &HeaderMap) -> Result<Holder, RpcError> {
        let Door::Guarded { tokens, certified } = self else {
            return Ok(Holder { who: "the daemon's user".to_owned(), rights: vec![Right::Admin] });
        };
        let Some(given) = headers.get(header::AUTHORIZATION) else {
            if !certified.is_empty() {
                let who = "the holder of a client certificate".to_owned();
                return Ok(Holder { who, rights: certified.clone() });
            }
            return Err(unknown("a token is needed here")
                .help("send one as `Authorization: Bearer TOKEN`; genomctl has --token-file"));
        };
        let token = given.as_bytes().strip_prefix(b"Bearer ").unwrap_or_default();
        let mut holder = tokens
            .holder(token)
            .ok_or_else(|| unknown("this token is not known here").help(KNOWN))?;
        holder.rights.extend(certified);
        Ok(holder)
    }
}

const KNOWN: &str = "the file at rpc.token_file of the daemon's configuration lists the known ones";

fn unknown(message: &str) -> RpcError {
    RpcError::new(StatusCode::UNAUTHORIZED, "unauthorized", message)
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
        Ok(holder) => {
            if let Some(holder) = holder {
                request.extensions_mut().insert(holder);
            }
            next.run(request).await
        }
        Err(refused) => {
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
    let holder = gate.door.holder(request.headers())?;
    // Of no known path, nothing but that is told, and only to those who have a token.
    if let Some(Some(right)) = asked {
        holder.may(*right, format_args!("{method} {}", request.uri().path()))?;
    }
    Ok(Some(holder))
}
