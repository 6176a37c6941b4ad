//! The tokens of clients.

use std::sync::Arc;

use axum::{Extension, Json};
use genom_doors::{RpcError, Tokens};
use genom_protocol::{Code, Reloaded};

/// Read the token file again.
///
/// Tokens that are not in it any more are refused from the next request on. If the file has a
/// mistake, nothing changes. SIGHUP has the same effect.
#[utoipa::path(
    post,
    path = "/tokens/reload",
    tag = "daemon",
    responses((status = 200, body = Reloaded), (status = 409))
)]
pub(crate) async fn reload(
    Extension(tokens): Extension<Arc<Tokens>>,
) -> Result<Json<Reloaded>, RpcError> {
    let tokens = tokens.read_again().map_err(|error| {
        RpcError::conflict(Code::TokenFile, error.to_string())
            .help("nothing was changed: the tokens are those of before")
    })?;
    Ok(Json(Reloaded { tokens }))
}
