//! Refusals that several handlers have in common.

use axum::http::StatusCode;
use genom_doors::RpcError;
use genom_middleware::OpenError;
use genom_protocol::Code;
use genom_runtime::HeldUp;
use genom_supervisor::connections::ConnectError;
use genom_supervisor::connections::feed::FeedError;

/// A codel blocks the request because it does not return, 503: nothing was done.
#[must_use]
pub fn held_up(error: &HeldUp) -> RpcError {
    let name = &error.instance;
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::HeldUp, error.to_string()).help(format!(
        "nothing was done; when it returns, ask again; `genomctl unload {name}` stops the rest of \
         the component and frees its name"
    ))
}

/// An in port or a remote was not connected, or not disconnected.
#[must_use]
pub fn not_connected(error: &ConnectError) -> RpcError {
    let (status, place) = match error {
        ConnectError::HeldUp(error) => return held_up(error),
        ConnectError::NoSuchInport { .. } => (StatusCode::NOT_FOUND, "/in"),
        ConnectError::NoSuchOutport { .. } => (StatusCode::NOT_FOUND, "/out"),
        ConnectError::Type { .. } => (StatusCode::CONFLICT, "/out"),
        ConnectError::Backend(_) | ConnectError::Stays { .. } => {
            (StatusCode::UNPROCESSABLE_ENTITY, "/over")
        }
        ConnectError::Policy { .. } => (StatusCode::UNPROCESSABLE_ENTITY, "/policy"),
        ConnectError::Failed(_) | ConnectError::End { .. } => (StatusCode::BAD_GATEWAY, "/out"),
    };
    let refused = RpcError::new(status, error.code(), error.message()).place(place);
    match error.help() {
        Some(help) => refused.help(help),
        None => refused,
    }
}

/// A value was not published to an in port.
#[must_use]
pub fn not_published(error: &FeedError) -> RpcError {
    let message = error.to_string();
    match error {
        FeedError::OutPort(_) => RpcError::conflict(Code::OutPort, message),
        FeedError::Connected { inport, .. } => RpcError::conflict(Code::Connected, message)
            .help(format!("`genomctl disconnect {inport}` first, to feed it from here")),
        FeedError::HeldUp(error) => held_up(error),
        FeedError::Value(error) => RpcError::bad_input(message).inside(&error.path),
        FeedError::Message(_) | FeedError::Bytes(_) => RpcError::bad_input(message),
        FeedError::Open(OpenError::Taken { .. }) => RpcError::conflict(Code::Taken, message)
            .help("another program publishes there: stop it first"),
        FeedError::Backend(_) | FeedError::Open(_) | FeedError::Publish { .. } => {
            RpcError::new(StatusCode::BAD_GATEWAY, Code::MiddlewareFailed, message)
        }
    }
}
