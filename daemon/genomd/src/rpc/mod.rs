//! The control plane: HTTP/1.1 and JSON, one file a resource.
//!
//! | Path | |
//! |---|---|
//! | `GET /` | what this daemon is |
//! | `GET, POST /components` | list, load |
//! | `GET, DELETE /components/{c}` | describe, unload |
//! | `GET, POST /components/{c}/services/{s}` | describe, call or start |
//! | `GET /components/{c}/activities` | list |
//! | `GET, DELETE /components/{c}/activities/{id}` | look or wait, abort |
//! | `GET /ports`, `GET /components/{c}/ports[/{p}[/stream]]` | ports, values, streams |
//! | `POST /components/{c}/ports/{p}` | publish to an in port |
//! | `GET /components/{c}/ports/{p}/type` | its type as it lies in memory |
//! | `POST /components/{c}/events/{e}` | fire |
//! | `GET /components/{c}/ports/{p}/traffic` | counts that rates are made of |
//! | `GET /components/{c}/tasks` | statistics |
//! | `GET /components/{c}/ports/{p}/why` | why no data flows |
//! | `PUT /components/{c}/backend` | move to another middleware while it runs |
//! | `GET, POST /connections`, `DELETE /connections/{c}/{p}[/{element}]` | wiring |
//! | `GET, POST /clock` | the date, step |
//! | `GET, POST /deployment` | the whole system as a file: dump; plan and apply |
//! | `GET /metrics` | figures for Prometheus |
//! | `GET /logs[/stream]` | what the daemon logged lately, and as it does |
//! | `GET /middlewares` | what they can do, what is visible on them |
//! | `GET /events` | what changes, as it happens |
//! | `POST /shutdown` | stop the daemon |
//!
//! Statuses: 2xx, the daemon did it; how a *service* ended is in the body, `result` or
//! `exception`, since an exception is an answer of the component and not a failure of the
//! request. 4xx and 5xx: refused, nothing ran, `{"error": {...}}` says why.

mod activities;
mod backends;
mod clock;
mod components;
mod connections;
mod daemon;
mod deployment;
mod error;
mod events;
mod input;
pub(crate) mod listen;
mod logs;
mod metrics;
mod middlewares;
mod ports;
pub(crate) mod serve;
mod services;
mod stream;
mod tasks;
mod why;

use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{Method, StatusCode, Uri, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse as _, Response};
use axum::routing::{delete, get, post, put};

use crate::daemon::Daemon;
use error::RpcError;

/// Every path of the control plane.
pub(crate) fn router(daemon: Arc<Daemon>) -> Router {
    let max_body = daemon.settings.rpc.max_body;
    Router::new()
        .route("/", get(daemon::about))
        .route("/shutdown", post(daemon::shutdown))
        .route("/components", get(components::list).post(components::load))
        .route("/components/{component}", get(components::describe).delete(components::unload))
        .route(
            "/components/{component}/services/{service}",
            get(services::describe).post(services::call),
        )
        .route("/components/{component}/activities", get(activities::list))
        .route(
            "/components/{component}/activities/{activity}",
            get(activities::look).delete(activities::abort),
        )
        .route("/components/{component}/ports", get(ports::of_component))
        .route("/components/{component}/ports/{port}", get(ports::value).post(ports::publish))
        .route("/components/{component}/ports/{port}/type", get(ports::layout))
        .route("/components/{component}/ports/{port}/stream", get(ports::stream))
        .route("/components/{component}/ports/{port}/traffic", get(ports::traffic))
        .route("/components/{component}/events/{event}", post(events::fire))
        .route("/components/{component}/tasks", get(tasks::statistics))
        .route("/components/{component}/ports/{port}/why", get(why::explain))
        .route("/components/{component}/backend", put(backends::change))
        .route("/ports", get(ports::all))
        .route("/connections", get(connections::list).post(connections::connect))
        .route("/connections/{component}/{port}", delete(connections::disconnect))
        .route("/connections/{component}/{port}/{element}", delete(connections::disconnect_element))
        .route("/clock", get(clock::look).post(clock::step))
        .route("/deployment", get(deployment::dump).post(deployment::apply))
        .route("/metrics", get(metrics::text))
        .route("/middlewares", get(middlewares::list))
        .route("/logs", get(logs::list))
        .route("/logs/stream", get(logs::stream))
        .route("/events", get(events::stream))
        .fallback(no_such_path)
        .method_not_allowed_fallback(no_such_method)
        .layer(from_fn(refuse_browsers))
        .layer(from_fn_with_state(max_body, refuse_large))
        .layer(DefaultBodyLimit::max(max_body))
        .with_state(daemon)
}

async fn no_such_path(uri: Uri) -> RpcError {
    RpcError::new(StatusCode::NOT_FOUND, "no_such_path", format!("no resource `{}`", uri.path()))
        .help("GET / lists them")
}

async fn no_such_method(method: Method, uri: Uri) -> RpcError {
    let message = format!("`{}` takes no {method}", uri.path());
    RpcError::new(StatusCode::METHOD_NOT_ALLOWED, "no_such_method", message)
}

/// A page of some web site must not drive a robot through its visitor's loopback.
async fn refuse_browsers(request: Request, next: Next) -> Response {
    if request.headers().contains_key(header::ORIGIN) {
        let message = "requests from web pages are not served";
        return RpcError::new(StatusCode::FORBIDDEN, "origin", message).into_response();
    }
    next.run(request).await
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
