//! Recordings and replays that are under way: how they end.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_cells::Kept;
use genom_cells::kept::Active;
use genom_doors::RpcError;
use genom_protocol::{Code, KeptRecording, KeptReplay};
use genom_supervisor::Supervisor;
use tokio::time::timeout;

use crate::refused::{at_work, refused};

/// How long the beginning and the end of a file are waited for.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// Ends a recording after this time, if it is not over before.
pub fn end_by_itself(supervisor: Arc<Supervisor>, active: Arc<Active>, after: Duration) {
    tokio::spawn(async move {
        tokio::select! {
            () = tokio::time::sleep(after) => stop(&supervisor, &active),
            () = active.over() => {}
        }
    });
}

/// Asks for the end of one that has begun.
fn stop(supervisor: &Supervisor, active: &Active) {
    if let Some(number) = active.number() {
        supervisor.recordings.end(number);
    }
}

/// End a recording; answers when its file is whole.
#[utoipa::path(
    post,
    path = "/recordings/kept/{file}/end",
    tag = "recordings",
    responses((status = 200, body = KeptRecording), (status = 404), (status = 409), (status = 503))
)]
pub async fn end(
    State(kept): State<Arc<Kept>>,
    State(supervisor): State<Arc<Supervisor>>,
    Path(file): Path<String>,
) -> Result<Json<KeptRecording>, RpcError> {
    let active = kept.active(&file).map_err(refused)?;
    stop(&supervisor, &active);
    if timeout(PATIENCE, active.over()).await.is_err() {
        let message = format!("{file} has no end yet: a process does not send its last samples");
        return Err(RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::UnderWay, message));
    }
    at_work(&kept, move |kept| kept.one(&file)).await.map(Json)
}

/// End the replay of a recording.
#[utoipa::path(
    delete,
    path = "/recordings/kept/{file}/replay",
    tag = "recordings",
    responses((status = 200, body = KeptReplay), (status = 404), (status = 409))
)]
pub async fn stop_play(
    State(kept): State<Arc<Kept>>,
    Path(file): Path<String>,
) -> Result<Json<KeptReplay>, RpcError> {
    let play = kept.replay(&file).map_err(refused)?;
    play.stop().await;
    Ok(Json(play.told()))
}
