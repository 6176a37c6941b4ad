//! What components were made of.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_doors::RpcError;
use genom_protocol::{Code, Sources};
use genom_supervisor::Supervisor;

use crate::rpc::components;

/// Get what a component was made of: the texts of its description as they were when it was loaded,
/// and how its tasks are executed.
///
/// `genomctl verify` and `genomctl schedule` read the description again from them. Texts of more
/// than 16 MiB are refused.
#[utoipa::path(
    get,
    path = "/components/{component}/sources",
    tag = "components",
    responses((status = 200, body = Sources), (status = 404), (status = 413))
)]
pub(crate) async fn sources(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Sources>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let sources = hosted.sources(&supervisor.settings);
    let size: usize = sources.texts.iter().map(|text| text.text.len()).sum();
    if size > Sources::LARGEST {
        tracing::warn!("the texts of {component} are not sent: they have {size} bytes");
        let message = format!("the description of {component} has {size} bytes");
        return Err(RpcError::new(StatusCode::PAYLOAD_TOO_LARGE, Code::TooLarge, message)
            .help("read it from its files"));
    }
    Ok(Json(sources))
}
