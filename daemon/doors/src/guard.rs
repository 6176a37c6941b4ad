//! Checks that apply to every request, before the handlers.

use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use genom_protocol::Code;

use crate::access::{self, Door, Gate};
use crate::error::RpcError;
use crate::input;
use crate::rights::Rights;

/// Header by which old clients selected another daemon, and sent their token to it.
const OLD_HEADER: &str = "genomd-daemon";

/// Most bytes of the bodies of requests.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// Of all requests.
    pub most: usize,
    /// Of requests to these paths, which are for administrators, if that is more.
    pub large: &'static [(&'static str, usize)],
}

impl From<usize> for Bodies {
    fn from(most: usize) -> Self {
        Self { most, large: &[] }
    }
}

impl Bodies {
    fn of(&self, path: &str) -> usize {
        let large = self.large.iter().find(|(large, _)| *large == path);
        large.map_or(self.most, |(_, most)| self.most.max(*most))
    }
}

/// Puts a door before a router. Handlers only receive requests whose senders have the right that
/// the table requires, with the [`Holder`](crate::holder::Holder) as an extension, and with a
/// complete body of at most as many bytes as `bodies` says.
pub fn guard(router: Router, rights: Rights, door: Door, bodies: impl Into<Bodies>) -> Router {
    let guarded = door.asks_for_a_token();
    let gate = Arc::new(Gate { door, rights });
    router
        .layer(from_fn_with_state(Arc::clone(&gate), access::refuse_method))
        .layer(from_fn(refuse_old))
        .layer(from_fn(input::read_whole))
        .layer(from_fn_with_state(gate, access::check))
        .layer(from_fn_with_state(guarded, refuse_browsers))
        .layer(from_fn_with_state(Arc::new(bodies.into()), refuse_large))
}

/// Refuses requests from web pages, which must not control a robot through the loopback of their
/// visitor. The service's own page is allowed where tokens are required.
async fn refuse_browsers(State(guarded): State<bool>, request: Request, next: Next) -> Response {
    if request.headers().contains_key(header::ORIGIN) && !(guarded && own_page(request.headers())) {
        let message = "requests from web pages are not served";
        return RpcError::new(StatusCode::FORBIDDEN, Code::Origin, message).into_response();
    }
    next.run(request).await
}

/// Whether a request comes from a page of this service.
fn own_page(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let origin = text(header::ORIGIN).and_then(|origin| origin.split_once("://"));
    origin.is_some_and(|(_, origin)| text(header::HOST) == Some(origin))
}

/// Refuses a body that is too large before it is sent, if its length is given: the peer then reads
/// the reply.
async fn refuse_large(
    State(bodies): State<Arc<Bodies>>,
    mut request: Request,
    next: Next,
) -> Response {
    let most = bodies.of(request.uri().path());
    let length = request.headers().get(header::CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > most as u64) {
        return RpcError::too_large().into_response();
    }
    DefaultBodyLimit::max(most).apply(&mut request);
    next.run(request).await
}

/// Refuses requests that are meant for another daemon, so that this one does not execute them.
async fn refuse_old(request: Request, next: Next) -> Response {
    if !request.headers().contains_key(OLD_HEADER) {
        return next.run(request).await;
    }
    let message = "requests to other daemons are not passed on with a token any more: it would go \
                   to whoever answers to the name";
    RpcError::new(StatusCode::BAD_REQUEST, Code::OldClient, message)
        .help("use the genomctl or the Python client of this version")
        .into_response()
}
