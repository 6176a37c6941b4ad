//! The tokens of those who come in.

use std::sync::Arc;

use axum::{Extension, Json};
use genom_doors::{RpcError, Tokens};
use genom_protocol::{Code, Reloaded};

/// Read the token file again.
///
/// What was taken out of it counts no more, from the next request on. A file with a mistake
/// changes nothing. SIGHUP does the same.
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
