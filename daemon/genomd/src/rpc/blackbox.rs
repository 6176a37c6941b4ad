//! The black box: how it is, and what it keeps.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse as _, Response};
use axum::{Extension, Json};
use genom_cells::{BlackBoxes, Cells, SaveError};
use genom_doors::{Holder, RpcError, Streams};
use genom_protocol::{BlackBox, BlackBoxLeft, Code};
use genom_supervisor::Supervisor;
use tokio::sync::mpsc;
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::ReceiverStream;

const WAITING: usize = 4;

/// How the black box is, and which files it wrote.
#[utoipa::path(get, path = "/blackbox", tag = "recordings", responses((status = 200, body = BlackBox)))]
pub(crate) async fn look(
    State(boxes): State<Arc<BlackBoxes>>,
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> Result<Json<BlackBox>, RpcError> {
    let unmatched = boxes.unmatched(&supervisor, cells.all()).await;
    let told = tokio::task::spawn_blocking(move || boxes.told(unmatched)).await;
    told.map(Json).map_err(|error| RpcError::internal(error.to_string()))
}

/// Write what the black box keeps to a file in its directory.
#[utoipa::path(
    post,
    path = "/blackbox",
    tag = "recordings",
    responses((status = 200, body = BlackBoxLeft), (status = 409))
)]
pub(crate) async fn save(
    State(boxes): State<Arc<BlackBoxes>>,
) -> Result<Json<BlackBoxLeft>, RpcError> {
    boxes.save().await.map(Json).map_err(|error| match error {
        SaveError::Off => off(),
        error => RpcError::internal(error.to_string()),
    })
}

/// What the black box keeps. The reply is a stream of frames, as of a recording.
#[utoipa::path(
    get,
    path = "/blackbox/frames",
    tag = "recordings",
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 409),
        (status = 503)
    )
)]
pub(crate) async fn frames(
    State(boxes): State<Arc<BlackBoxes>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
) -> Result<Response, RpcError> {
    if !boxes.is_kept() {
        return Err(off());
    }
    let slot = streams.slot(&holder)?;
    let (sender, receiver) = mpsc::channel(WAITING);
    tokio::task::spawn_blocking(move || {
        let _ = boxes.send(&sender);
        drop(slot);
    });
    let batches =
        ReceiverStream::new(receiver).map(|batch| Ok::<_, Infallible>(Bytes::from(batch)));
    let kind = [(header::CONTENT_TYPE, "application/octet-stream")];
    Ok((kind, Body::from_stream(batches)).into_response())
}

fn off() -> RpcError {
    RpcError::conflict(Code::NoBlackBox, SaveError::Off.to_string())
        .help("set blackbox.enabled = true in the configuration, and start the daemon again")
}
