//! Recordings that the daemon makes itself, and replays: how they begin, in all its processes.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Path, State};
use axum::{Extension, Json};
use genom_archive::{PATIENCE, at_work, choose, end_by_itself, refused};
use genom_cells::kept::PlayError;
use genom_doors::{Body, Holder, Own, RpcError};
use genom_protocol::{KeepRequest, KeptRecording, KeptReplay, RecordingRequest, ReplayRequest};
use tokio::sync::mpsc;
use tokio::time::timeout;

use crate::daemon::Daemon;
use crate::rpc::{recordings, replay};

/// Longest recording that ends by itself, in seconds.
const LONGEST: f64 = 86_400.0;

/// Record ports and calls of services into a file that the daemon keeps.
#[utoipa::path(
    post,
    path = "/recordings/kept",
    tag = "recordings",
    request_body = KeepRequest,
    responses(
        (status = 200, body = KeptRecording),
        (status = 404),
        (status = 409),
        (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn begin(
    State(daemon): State<Arc<Daemon>>,
    Extension(holder): Extension<Holder>,
    Body(wanted): Body<KeepRequest>,
) -> Result<Json<KeptRecording>, RpcError> {
    if let Some(seconds) = wanted.seconds.filter(|seconds| !(0.0..=LONGEST).contains(seconds)) {
        let message = format!("seconds: {seconds} is not between 0 and {LONGEST}");
        return Err(RpcError::bad_input(message).place("/seconds"));
    }
    // All of it is done, also for a client that goes meanwhile: nothing is left half begun.
    let begun = tokio::spawn(begun(daemon, holder, wanted)).await;
    begun.map_err(|error| RpcError::internal(error.to_string()))?.map(Json)
}

async fn begun(
    daemon: Arc<Daemon>,
    holder: Holder,
    wanted: KeepRequest,
) -> Result<KeptRecording, RpcError> {
    let KeepRequest { name, ports, seconds } = wanted;
    let request = RecordingRequest { ports, times: false, ordered: true };
    recordings::check(&daemon.supervisor, &daemon.cells, &request)?;
    let ports = request.ports.clone();
    let made = at_work(&daemon.kept, move |kept| kept.create(name.as_deref(), &ports)).await?;
    let supervisor = Arc::clone(&daemon.supervisor);
    let begun = recordings::begin(supervisor, &daemon.cells, request, ()).await;
    let (frames, failed) = match begun {
        Ok((frames, _)) => (frames, None),
        // Without frames, the file goes.
        Err(error) => (mpsc::channel(1).1, Some(error)),
    };
    let (kept, active) = (Arc::clone(&daemon.kept), Arc::clone(&made));
    tokio::task::spawn_blocking(move || kept.write(&active, frames));
    if let Some(failed) = failed {
        return Err(failed);
    }
    // It has a number then, by which it can be ended.
    let _ = timeout(PATIENCE, made.begun()).await;
    tracing::info!("recording {} begins, for {}", made.file, holder.who);
    if let Some(seconds) = seconds {
        let after = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        end_by_itself(Arc::clone(&daemon.supervisor), Arc::clone(&made), after);
    }
    let file = made.file.clone();
    at_work(&daemon.kept, move |kept| kept.one(&file)).await
}

/// Publish the samples of a recording to the in ports that they were read or written under, with
/// their timing.
///
/// In ports that are connected, or have another type now, are left out.
#[utoipa::path(
    post,
    path = "/recordings/kept/{file}/replay",
    tag = "recordings",
    request_body = ReplayRequest,
    responses(
        (status = 200, body = KeptReplay),
        (status = 404),
        (status = 409),
        (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn play(
    State(daemon): State<Arc<Daemon>>,
    Extension(own): Extension<Own>,
    Extension(holder): Extension<Holder>,
    Path(file): Path<String>,
    Body(wanted): Body<ReplayRequest>,
) -> Result<Json<KeptReplay>, RpcError> {
    let rate = wanted.rate.unwrap_or(1.0);
    if !(0.01..=100.0).contains(&rate) {
        let message = format!("rate: {rate} is not between 0.01 and 100");
        return Err(RpcError::bad_input(message).place("/rate"));
    }
    let name = file.clone();
    let (recording, voices) = at_work(&daemon.kept, move |kept| kept.voices(&name)).await?;
    let chosen = choose(&own, voices).await;
    let to = Arc::clone(&daemon);
    let publish = move |bytes: Vec<u8>| {
        let daemon = Arc::clone(&to);
        async move {
            let published = replay::all(&daemon.supervisor, &daemon.cells, bytes.into()).await;
            published.map_err(|refused| PlayError::Refused(refused.message().to_owned()))
        }
    };
    let play = daemon.kept.play(&file, recording, chosen, rate, publish).map_err(refused)?;
    tracing::info!("replay of {file} begins, for {}", holder.who);
    Ok(Json(play.told()))
}
