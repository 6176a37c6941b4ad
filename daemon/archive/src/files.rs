//! Files of recordings: listed, sent and removed.

use std::io::{self, Read};
use std::sync::Arc;

use axum::body::{Body as Stream, Bytes};
use axum::extract::{Path, State};
use axum::http::header;
use axum::response::{IntoResponse as _, Response};
use axum::{Extension, Json};
use genom_cells::Kept;
use genom_doors::{Holder, RpcError, Streams};
use genom_protocol::{KeptRecordings, RecordingRemoved};
use tokio_stream::wrappers::ReceiverStream;

use crate::refused::at_work;

/// Bytes of a file that are read at once, and such pieces that wait to be sent.
const PIECE: usize = 64 << 10;
const WAITING: usize = 4;

/// List the recordings that the daemon keeps.
#[utoipa::path(
    get,
    path = "/recordings/kept",
    tag = "recordings",
    responses((status = 200, body = KeptRecordings))
)]
pub async fn list(State(kept): State<Arc<Kept>>) -> Result<Json<KeptRecordings>, RpcError> {
    at_work(&kept, |kept| Ok(Json(kept.told()))).await
}

/// Get the file of a recording that is not under way, as MCAP.
#[utoipa::path(
    get,
    path = "/recordings/kept/{file}",
    tag = "recordings",
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 404),
        (status = 409)
    )
)]
pub async fn file(
    State(kept): State<Arc<Kept>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    Path(name): Path<String>,
) -> Result<Response, RpcError> {
    let slot = streams.slot(&holder)?;
    let wanted = name.clone();
    let found = at_work(&kept, move |kept| kept.open(&wanted)).await?;
    let size = found.metadata().map_err(|error| RpcError::internal(error.to_string()))?.len();
    let (sender, pieces) = tokio::sync::mpsc::channel(WAITING);
    tokio::task::spawn_blocking(move || {
        send(found.take(size), &sender);
        drop(slot);
    });
    // The name has only characters that may stand there.
    let about = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_LENGTH, size.to_string()),
        (header::CONTENT_DISPOSITION, format!("attachment; filename=\"{name}\"")),
    ];
    Ok((about, Stream::from_stream(ReceiverStream::new(pieces))).into_response())
}

/// Sends a file until its end, or until nobody takes it any more.
fn send(mut file: impl Read, to: &tokio::sync::mpsc::Sender<io::Result<Bytes>>) {
    loop {
        let mut piece = vec![0; PIECE];
        let piece = match file.read(&mut piece) {
            Ok(0) => return,
            Ok(length) => {
                piece.truncate(length);
                Ok(Bytes::from(piece))
            }
            Err(error) => Err(error),
        };
        let failed = piece.is_err();
        if to.blocking_send(piece).is_err() || failed {
            return;
        }
    }
}

/// Remove a recording.
#[utoipa::path(
    delete,
    path = "/recordings/kept/{file}",
    tag = "recordings",
    responses((status = 200, body = RecordingRemoved), (status = 404), (status = 409))
)]
pub async fn remove(
    State(kept): State<Arc<Kept>>,
    Extension(holder): Extension<Holder>,
    Path(file): Path<String>,
) -> Result<Json<RecordingRemoved>, RpcError> {
    let removed = file.clone();
    at_work(&kept, move |kept| kept.remove(&file)).await?;
    tracing::info!("recording {removed} was removed, for {}", holder.who);
    Ok(Json(RecordingRemoved { removed }))
}
