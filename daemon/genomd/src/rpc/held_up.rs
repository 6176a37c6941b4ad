//! The refusal of a request that a codel blocks because it does not return.

use axum::http::StatusCode;
use genom_doors::RpcError;
use genom_protocol::Code;
use genom_runtime::HeldUp;

/// 503: nothing was done.
pub(super) fn held_up(error: &HeldUp) -> RpcError {
    let name = &error.instance;
    RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::HeldUp, error.to_string()).help(format!(
        "nothing was done; when it returns, ask again; `genomctl unload {name}` stops the rest of \
         the component and frees its name"
    ))
}
