//! Cells: list, end, restart; and what is passed on to them.

use std::sync::Arc;

use axum::Json;
use axum::body::Body;
use axum::extract::{FromRequestParts as _, MatchedPath, Path, RawPathParams, Request, State};
use axum::http::{Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use genom_cells::{AskError, Cell, Cells, Down, OpenError, StoreError};
use genom_doors::{Holder, RpcError};
use genom_protocol::{CallReply, CellEnds, CellState, Code, CrashReport, Crashes, Outcome, routes};
use genom_views::not_connected;
use serde_json::json;

/// List the cells: processes of their own for components.
#[utoipa::path(
    get,
    path = "/cells",
    tag = "cells",
    responses((status = 200, body = genom_protocol::Cells))
)]
pub(crate) async fn list(State(cells): State<Arc<Cells>>) -> Json<genom_protocol::Cells> {
    let cells = cells.with_gateways().iter().map(|cell| cell.told()).collect();
    Json(genom_protocol::Cells { cells })
}

/// End a cell with all that is in it.
///
/// Its components stop as they do when they are unloaded.
#[utoipa::path(
    delete,
    path = "/cells/{cell}",
    tag = "cells",
    responses((status = 200, body = CellEnds), (status = 404))
)]
pub(crate) async fn end(
    State(cells): State<Arc<Cells>>,
    Path(cell): Path<String>,
) -> Result<Json<CellEnds>, RpcError> {
    find(&cells, &cell)?;
    cells.stop(&cell).await;
    Ok(Json(CellEnds { cell }))
}

/// Kill the process of a cell, as a fault would; its components come back as their policies say.
///
/// The process of a cell that has failed, or that is to be started later, starts now. Answers when
/// the cell runs again.
#[utoipa::path(
    post,
    path = "/cells/{cell}/restart",
    tag = "cells",
    responses((status = 200, body = genom_protocol::Cell), (status = 404), (status = 503))
)]
pub(crate) async fn restart(
    State(cells): State<Arc<Cells>>,
    Path(cell): Path<String>,
) -> Result<Json<genom_protocol::Cell>, RpcError> {
    let cell = find(&cells, &cell)?;
    cell.restart().await.map_err(|error| down(&error))?;
    Ok(Json(cell.told()))
}

/// List the reports of cells whose process ended without being asked to.
#[utoipa::path(get, path = "/crashes", tag = "cells", responses((status = 200, body = Crashes)))]
pub(crate) async fn crashes(State(cells): State<Arc<Cells>>) -> Json<Crashes> {
    Json(cells.crashes().await)
}

/// One of these reports: signal, codel, inputs, backtrace, statistics, log.
#[utoipa::path(
    get,
    path = "/crashes/{crash}",
    tag = "cells",
    responses((status = 200, body = CrashReport), (status = 404))
)]
pub(crate) async fn crash(
    State(cells): State<Arc<Cells>>,
    Path(crash): Path<String>,
) -> Result<Json<CrashReport>, RpcError> {
    let found = cells.crash(&crash).await;
    found.map(Json).map_err(|(error, names)| match error {
        StoreError::Unknown(_) => RpcError::unknown(
            Code::NoSuchCrash,
            "no report",
            &crash,
            names.iter().map(String::as_str),
        ),
        error => RpcError::internal(error.to_string()),
    })
}

fn find(cells: &Cells, name: &str) -> Result<Arc<Cell>, RpcError> {
    cells.get(name).ok_or_else(|| {
        let all = cells.with_gateways();
        let names = all.iter().map(|cell| cell.name());
        RpcError::unknown(Code::NoSuchCell, "no cell", name, names)
    })
}

/// Passes a request on to the cell that holds its component; others go on to the handlers.
pub(super) async fn pass_on(
    State(cells): State<Arc<Cells>>,
    request: Request,
    next: Next,
) -> Response {
    let (mut parts, body) = request.into_parts();
    // A path that is no route has none.
    let parameters = RawPathParams::from_request_parts(&mut parts, &()).await.ok();
    let of = |wanted| {
        let mut all = parameters.iter().flatten();
        all.find(|(name, _)| *name == wanted).map(|(_, value)| value)
    };
    // What is taken out of a cell may end it: the handler does that.
    let path = parts.extensions.get::<MatchedPath>().map(MatchedPath::as_str);
    let unload = parts.method == Method::DELETE && path == Some("/components/{component}");
    let ends = path == Some("/components/{component}/ends");
    let request = Request::from_parts(parts, body);
    let cell = of("component").filter(|_| !unload).and_then(|component| cells.of(component));
    let Some(cell) = cell else { return next.run(request).await };
    let call = *request.method() == Method::POST;
    let service = of("service").filter(|_| call).map(str::to_owned);
    if let Some(service) = &service
        && let Err(refused) = may(&request, service)
    {
        return refused.into_response();
    }
    let forwarded = cell.forward(request).await;
    if let Some(component) = of("component").filter(|_| ends) {
        cells.tell_again(component);
    }
    match forwarded {
        Ok(response) => response.map(Body::new),
        Err(error) => match service {
            // An answer of the component, as any other exception: it was asked, and is gone.
            Some(_) if error.state != CellState::Failed => gone(&error).into_response(),
            _ => down(&error).into_response(),
        },
    }
}

/// Services that every component has do what other routes do, and ask for the same rights; the
/// cell itself takes whatever comes through this daemon.
fn may(request: &Request, service: &str) -> Result<(), RpcError> {
    let holder = request.extensions().get::<Holder>();
    match holder {
        Some(holder) if routes::is_standard_service(service) => {
            let right = routes::right_of_standard_service(service);
            holder.may(right, format_args!("service {service}"))
        }
        Some(_) => Ok(()),
        None => Err(RpcError::internal("a request without a holder")),
    }
}

/// How a call ends whose component went away with its cell.
fn gone(error: &Down) -> Json<CallReply> {
    let outcome =
        Outcome::of_exception("::genom::gone", json!({"cell": error.cell, "why": error.last_end}));
    Json(CallReply::Ended(outcome))
}

pub(super) fn down(error: &Down) -> RpcError {
    let help = match error.state {
        CellState::Failed => format!("`genomctl cells --restart {}` starts it again", error.cell),
        _ => "ask again in a moment; `genomctl cells` tells how it is".to_owned(),
    };
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::CellDown, error.to_string()).help(help)
}

/// A cell did not do what it was asked.
pub(super) fn refused(error: OpenError) -> RpcError {
    match error {
        OpenError::Place(error) => RpcError::bad_input(error.to_string()).place("/cell"),
        OpenError::End(error) => not_connected(&error),
        OpenError::Elsewhere { .. } => RpcError::conflict(Code::NoPlan, error.to_string()),
        OpenError::Share(error) => {
            RpcError::new(StatusCode::BAD_GATEWAY, Code::MiddlewareFailed, error).place("/out")
        }
        OpenError::Down(error) => down(&error),
        error @ OpenError::Gone(_) => {
            let help = "the next load begins another one; `genomctl crashes` may tell more";
            RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::CellDown, error.to_string())
                .help(help)
        }
        OpenError::Ask(error) => not_done(error),
    }
}

/// The same of one request.
pub(super) fn not_done(error: AskError) -> RpcError {
    match error {
        AskError::Refused(status, reason) => {
            let status = StatusCode::from_u16(status).unwrap_or(StatusCode::BAD_GATEWAY);
            RpcError::passed_on(status, *reason)
        }
        error => {
            let status = StatusCode::SERVICE_UNAVAILABLE;
            RpcError::new(status, Code::CellDown, error.to_string())
        }
    }
}
