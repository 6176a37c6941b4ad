//! The control plane: HTTP/1.1 and JSON, one file per resource.
//!
//! `document` generates OpenAPI from the handlers: `/openapi.json`, and `/docs` to browse it. The
//! rights that routes require are listed in `genom_protocol::routes`, and checked by `genom_doors`.
//!
//! Statuses: 2xx means that the daemon did what was asked. The outcome of a *service* is in the
//! body, `result` or `exception`, because an exception is a reply of the component and not a
//! failure of the request. 4xx and 5xx mean that the request was refused and nothing was executed;
//! `{"error": {...}}` says why.

mod activities;
mod backends;
mod blackbox;
mod cells;
mod clock;
mod codels;
mod components;
mod connections;
mod daemon;
mod daemons;
mod deployment;
mod document;
mod events;
mod freeze;
mod kept;
mod logs;
mod metrics;
mod middlewares;
mod parts;
mod ports;
mod ready;
mod recordings;
mod replay;
mod services;
mod sources;
mod tasks;
mod tokens;
mod withheld;

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{StatusCode, Uri};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::{Extension, Router};
use genom_doors::{Bodies, Door, Own, Rights, RpcError, Tokens, guard};
use genom_protocol::Code;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::daemon::Daemon;
use document::Document;
use parts::Parts;

/// All paths of the control plane, with their parts of the document.
fn routes() -> OpenApiRouter<Parts> {
    OpenApiRouter::with_openapi(document::begun())
        .routes(routes!(daemon::about))
        .routes(routes!(components::list, components::load))
        .routes(routes!(components::describe, components::unload))
        .routes(routes!(components::reload))
        .routes(routes!(components::schema))
        .routes(routes!(sources::sources))
        .routes(routes!(cells::list))
        .routes(routes!(cells::end))
        .routes(routes!(cells::restart))
        .routes(routes!(cells::crashes))
        .routes(routes!(cells::crash))
        .routes(routes!(blackbox::look, blackbox::save))
        .routes(routes!(blackbox::frames))
        .routes(routes!(backends::change))
        .routes(routes!(backends::need))
        .routes(routes!(services::describe, services::call))
        .routes(routes!(activities::list, activities::abort_all))
        .routes(routes!(activities::stop))
        .routes(routes!(activities::look, activities::abort))
        .routes(routes!(ports::all))
        .routes(routes!(ports::of_component))
        .routes(routes!(ports::value, ports::publish))
        .routes(routes!(ports::layout))
        .routes(routes!(genom_views::stream))
        .routes(routes!(genom_views::plots))
        .routes(routes!(genom_views::image))
        .routes(routes!(ports::traffic))
        .routes(routes!(genom_views::why))
        .routes(routes!(genom_views::doctor))
        .routes(routes!(events::fire))
        .routes(routes!(events::stream))
        .routes(routes!(connections::list, connections::connect))
        .routes(routes!(connections::disconnect))
        .routes(routes!(connections::disconnect_element))
        .routes(routes!(deployment::dump, deployment::apply))
        .routes(routes!(deployment::take_back))
        .routes(routes!(freeze::freeze))
        .routes(routes!(freeze::thaw))
        .routes(routes!(freeze::go_on))
        .routes(routes!(tasks::statistics))
        .routes(routes!(recordings::channels))
        .routes(routes!(genom_views::histograms))
        .routes(routes!(genom_views::timeline))
        .routes(routes!(recordings::start))
        .routes(routes!(recordings::end))
        .routes(routes!(genom_archive::list, kept::begin))
        .routes(routes!(genom_archive::file, genom_archive::remove))
        .routes(routes!(genom_archive::end))
        .routes(routes!(kept::play, genom_archive::stop_play))
        .routes(routes!(replay::publish))
        .routes(routes!(metrics::text))
        .routes(routes!(logs::list))
        .routes(routes!(logs::stream))
        .routes(routes!(clock::look, clock::step))
        .routes(routes!(middlewares::list))
        .routes(routes!(daemons::list))
        .routes(routes!(daemons::hello))
        .routes(routes!(daemons::question))
        .routes(routes!(tokens::reload))
        .routes(routes!(genom_web::make_link))
        .routes(routes!(document::json))
        .routes(routes!(document::page))
        .routes(routes!(withheld::list))
        .routes(routes!(withheld::clear))
        .routes(routes!(daemon::shutdown))
        .routes(routes!(ready::ready))
}

/// The control plane for requests from `door`.
pub(crate) fn router(daemon: &Arc<Daemon>, tokens: &Arc<Tokens>, door: Door) -> Router {
    let (router, mut document) = routes().split_for_parts();
    document::complete(&mut document);
    let router = router
        .fallback(no_such_path)
        .layer(from_fn_with_state(Arc::clone(daemon), note))
        .layer(from_fn_with_state(Arc::clone(&daemon.cells), cells::pass_on));
    let own = Own::new(router.clone().with_state(Parts(Arc::clone(daemon))));
    let router = router
        .layer(Extension(own))
        .layer(Extension(Document::new(&document)))
        .layer(Extension(daemon.console.get().cloned()))
        .layer(Extension(Arc::clone(tokens)))
        .with_state(Parts(Arc::clone(daemon)));
    let rows = genom_protocol::routes::all();
    let rights = Rights::of(rows.iter().map(|row| (row.method, row.template, row.right)));
    let large = &[("/thaw", freeze::LARGEST)];
    guard(router, rights, door, Bodies { most: daemon.rpc.max_body, large })
}

/// In a cell, what a request changed is written down before it is answered.
async fn note(State(daemon): State<Arc<Daemon>>, request: Request, next: Next) -> Response {
    let changes = !request.method().is_safe();
    let response = next.run(request).await;
    if changes
        && response.status().is_success()
        && let Some(own) = daemon.own_cell.clone()
    {
        let writing = tokio::task::spawn_blocking(move || {
            own.write(&daemon.supervisor, daemon.startup.deployed.is_up());
        });
        let _ = writing.await;
    }
    response
}

async fn no_such_path(uri: Uri) -> RpcError {
    RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchPath, format!("no resource `{}`", uri.path()))
        .help("GET / lists them")
}
