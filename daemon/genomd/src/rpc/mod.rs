//! The control plane: HTTP/1.1 and JSON, one file a resource.
//!
//! `document` makes OpenAPI of the handlers: `/openapi.json`, and `/docs` to browse it. `access`
//! lets in whoever has the right that a route asks for.
//!
//! Statuses: 2xx, the daemon did it; how a *service* ended is in the body, `result` or
//! `exception`, since an exception is an answer of the component and not a failure of the
//! request. 4xx and 5xx: refused, nothing ran, `{"error": {...}}` says why.

pub(crate) mod access;
mod activities;
mod backends;
mod clock;
mod codels;
mod components;
mod connections;
mod daemon;
mod deployment;
mod document;
mod error;
mod events;
mod guests;
mod holder;
mod input;
pub(crate) mod listen;
mod logs;
mod metrics;
mod middlewares;
mod ports;
mod private;
mod ready;
mod recordings;
pub(crate) mod relay;
mod replay;
mod seldom;
pub(crate) mod serve;
mod services;
mod stall;
mod stranded;
mod stream;
mod tasks;
pub(crate) mod tls;
pub(crate) mod tokens;
mod values;
mod why;

use std::sync::Arc;

use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::{Extension, Router};
use genom_protocol::Code;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::daemon::Daemon;
use access::{Door, Gate};
use document::Document;
use error::RpcError;
use tokens::Tokens;

/// Every path of the control plane, with its part of the document.
fn routes() -> OpenApiRouter<Arc<Daemon>> {
    OpenApiRouter::with_openapi(document::begun())
        .routes(routes!(daemon::about))
        .routes(routes!(components::list, components::load))
        .routes(routes!(components::describe, components::unload))
        .routes(routes!(components::schema))
        .routes(routes!(backends::change))
        .routes(routes!(services::describe, services::call))
        .routes(routes!(activities::list, activities::abort_all))
        .routes(routes!(activities::stop))
        .routes(routes!(activities::look, activities::abort))
        .routes(routes!(ports::all))
        .routes(routes!(ports::of_component))
        .routes(routes!(ports::value, ports::publish))
        .routes(routes!(ports::layout))
        .routes(routes!(values::stream))
        .routes(routes!(ports::traffic))
        .routes(routes!(why::explain))
        .routes(routes!(events::fire))
        .routes(routes!(events::stream))
        .routes(routes!(connections::list, connections::connect))
        .routes(routes!(connections::disconnect))
        .routes(routes!(connections::disconnect_element))
        .routes(routes!(deployment::dump, deployment::apply))
        .routes(routes!(tasks::statistics))
        .routes(routes!(recordings::start))
        .routes(routes!(recordings::end))
        .routes(routes!(replay::publish))
        .routes(routes!(metrics::text))
        .routes(routes!(logs::list))
        .routes(routes!(logs::stream))
        .routes(routes!(clock::look, clock::step))
        .routes(routes!(middlewares::list))
        .routes(routes!(relay::list))
        .routes(routes!(relay::asking::hello))
        .routes(routes!(relay::asking::question))
        .routes(routes!(tokens::reload))
        .routes(routes!(document::json))
        .routes(routes!(document::page))
        .routes(routes!(daemon::shutdown))
        .routes(routes!(ready::ready))
}

/// The control plane, as it shows at a door.
pub(crate) fn router(daemon: Arc<Daemon>, tokens: &Arc<Tokens>, door: Door) -> Router {
    let max_body = daemon.rpc.max_body;
    let guarded = matches!(door, Door::Guarded { .. });
    let (router, mut document) = routes().split_for_parts();
    document::complete(&mut document);
    let gate = Arc::new(Gate { door, asked: document::rights(&document) });
    router
        .fallback(no_such_path)
        .method_not_allowed_fallback(no_such_method)
        .layer(from_fn(relay::refuse_old))
        .layer(from_fn(input::read_whole))
        .layer(Extension(Document::new(&document)))
        .layer(Extension(Arc::clone(tokens)))
        .layer(from_fn_with_state(gate, access::check))
        .layer(from_fn_with_state(guarded, refuse_browsers))
        .layer(from_fn_with_state(max_body, refuse_large))
        .layer(DefaultBodyLimit::max(max_body))
        .with_state(daemon)
}

async fn no_such_path(uri: Uri) -> RpcError {
    RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchPath, format!("no resource `{}`", uri.path()))
        .help("GET / lists them")
}

async fn no_such_method(method: Method, uri: Uri) -> RpcError {
    let message = format!("`{}` takes no {method}", uri.path());
    RpcError::new(StatusCode::METHOD_NOT_ALLOWED, Code::NoSuchMethod, message)
}

/// A page of some web site must not drive a robot through its visitor's loopback; our own page
/// may, where tokens are asked for.
async fn refuse_browsers(State(guarded): State<bool>, request: Request, next: Next) -> Response {
    if request.headers().contains_key(header::ORIGIN) && !(guarded && own_page(request.headers())) {
        let message = "requests from web pages are not served";
        return RpcError::new(StatusCode::FORBIDDEN, Code::Origin, message).into_response();
    }
    next.run(request).await
}

/// Whether a request comes from a page of this daemon.
fn own_page(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let origin = text(header::ORIGIN).and_then(|origin| origin.split_once("://"));
    origin.is_some_and(|(_, origin)| text(header::HOST) == Some(origin))
}

/// Refused before it is sent, when its length is said: the peer reads the answer then.
async fn refuse_large(State(most): State<usize>, request: Request, next: Next) -> Response {
    let length = request.headers().get(header::CONTENT_LENGTH);
    let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > most as u64) {
        return RpcError::too_large().into_response();
    }
    next.run(request).await
}
