//! Tasks: their statistics.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use serde_json::Value;

use crate::daemon::Daemon;
use crate::rpc::components;
use crate::rpc::error::RpcError;

/// `GET /components/{component}/tasks`
pub(crate) async fn statistics(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    Ok(Json(hosted.statistics()))
}
