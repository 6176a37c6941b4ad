//! Who may connect, and with which rights.
//!
//! Foxglove's protocol has no tokens, and browsers let any page open a WebSocket to any address: a
//! page elsewhere must not read or drive the robot of its visitor. Three checks keep it out:
//!
//! * `Host` must be an IP address, `localhost`, or a name of the configuration, because a page can
//!   make its own name stand for 127.0.0.1 (DNS rebinding).
//! * `Origin`, which browsers always send with a WebSocket, must be one of `foxglove.origins`.
//!   Programs that are no browsers send none.
//! * Beyond loopback every client needs a token of the token file. On loopback those without one
//!   have `foxglove.rights`.
//!
//! A token is in the address (`?token=TOKEN`), where Foxglove's users can type it, or in an
//! `Authorization` header.

use axum::extract::{Query, Request};
use axum::http::{HeaderMap, StatusCode, header};
use genom_doors::{Holder, Mark, RpcError, Tokens, one_header, own_name};
use genom_protocol::{Code, Right};
use serde::Deserialize;

use crate::terms::Terms;

/// A client that was admitted.
#[derive(Clone, Debug)]
pub(crate) struct Visitor {
    holder: Holder,
    /// The token that its rights rest on, if it has one.
    mark: Option<Mark>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Given {
    token: Option<String>,
}

impl Visitor {
    /// The client with the rights that it has now; `None` if its token is gone.
    pub(crate) fn now(&self, tokens: &Tokens) -> Option<Holder> {
        let Some(mark) = &self.mark else { return Some(self.holder.clone()) };
        let rights = tokens.rights(mark)?;
        Some(Holder { rights, ..self.holder.clone() })
    }
}

/// Who makes this request, unless it is refused.
pub(crate) fn admit(terms: &Terms, request: &Request) -> Result<Visitor, RpcError> {
    let headers = request.headers();
    // A whole address in the request line would count instead of `Host`.
    let host = one_header(headers, &header::HOST).filter(|_| request.uri().authority().is_none());
    if !host.is_some_and(|host| own_name(host, &terms.section.hosts)) {
        let help = "use an IP address, localhost or a name of foxglove.hosts";
        return Err(foreign("this host name is none of this daemon's").help(help));
    }
    if headers.contains_key(header::ORIGIN) {
        let origin = one_header(headers, &header::ORIGIN).unwrap_or("");
        let known = &terms.section.origins;
        if !known.iter().any(|known| known.eq_ignore_ascii_case(origin)) {
            let origin: String = origin.chars().take(100).collect();
            let message = format!("web pages of `{}` are not served", origin.escape_default());
            return Err(foreign(&message).help("foxglove.origins lists those that are"));
        }
    }
    let visitor = match token(request)? {
        Some(token) => {
            let unknown = || refused("this token is not known here");
            let holder = terms.tokens.holder(token.as_bytes()).ok_or_else(unknown)?;
            Visitor { mark: terms.tokens.mark(&holder), holder }
        }
        None if !terms.address.ip().is_loopback() => {
            return Err(refused("a token is needed here")
                .help("add ?token=TOKEN to the address, with one of rpc.token_file"));
        }
        None => {
            let rights = terms.section.rights.clone();
            Visitor { holder: Holder::of("a client of foxglove".to_owned(), rights), mark: None }
        }
    };
    visitor.holder.may(Right::Read, "this source")?;
    Ok(visitor)
}

fn token(request: &Request) -> Result<Option<String>, RpcError> {
    let Ok(Query(given)) = Query::<Given>::try_from_uri(request.uri()) else {
        return Err(refused("the address has something other than one ?token="));
    };
    Ok(given.token.or_else(|| bearer(request.headers())))
}

fn bearer(headers: &HeaderMap) -> Option<String> {
    let (scheme, token) = one_header(headers, &header::AUTHORIZATION)?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("Bearer").then(|| token.trim_start().to_owned())
}

fn foreign(message: &str) -> RpcError {
    RpcError::new(StatusCode::FORBIDDEN, Code::Origin, message)
}

fn refused(message: &str) -> RpcError {
    RpcError::new(StatusCode::UNAUTHORIZED, Code::Unauthorized, message)
}
