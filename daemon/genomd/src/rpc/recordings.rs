//! Recordings of ports and calls of services, as a stream of frames.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::{Body as Stream, Bytes};
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use genom_cells::Cells;
use genom_doors::{Body, Holder, RpcError, Streams};
use genom_protocol::address::NoAddress;
use genom_protocol::frames::{Channels, EVENTS, Start};
use genom_protocol::sse::LAST_EVENT_ID;
use genom_protocol::{Code, RecordingEnds, RecordingRequest, Subject};
use genom_supervisor::{Supervisor, recording};
use tokio::sync::mpsc;
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::ReceiverStream;

use crate::daemon::Daemon;
use crate::rpc::{self, clock, components, ports};

/// Maximum number of batches that wait to be sent.
const WAITING: usize = 4;

/// List the channels that a recording of everything would have now.
#[utoipa::path(
    get,
    path = "/channels",
    tag = "recordings",
    responses((status = 200, body = Channels))
)]
pub(crate) async fn channels(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> Json<Channels> {
    let mut own = Channels { channels: supervisor.channels() };
    cells.join_channels(&mut own).await;
    Json(own)
}

/// Record ports and calls of services. The reply is a stream of frames (`length: u32, kind: u8,
/// content`, little endian).
///
/// The header `Last-Event-ID` of the reply is the number of the last change (`GET /events`) before
/// the recording.
#[utoipa::path(
    post,
    path = "/recordings",
    tag = "recordings",
    request_body = RecordingRequest,
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 404),
        (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn start(
    State(supervisor): State<Arc<Supervisor>>,
    State(streams): State<Streams>,
    State(cells): State<Arc<Cells>>,
    Extension(holder): Extension<Holder>,
    Body(wanted): Body<RecordingRequest>,
) -> Result<Response, RpcError> {
    check(&supervisor, &cells, &wanted)?;
    let slot = streams.slot(&holder)?;
    let (receiver, after) = begin(supervisor, &cells, wanted, slot).await?;
    let batches =
        ReceiverStream::new(receiver).map(|batch| Ok::<_, Infallible>(Bytes::from(batch)));
    let kind = (header::CONTENT_TYPE.as_str(), "application/octet-stream".to_owned());
    let heads = [kind, (LAST_EVENT_ID, after.to_string())];
    Ok((heads, Stream::from_stream(batches)).into_response())
}

/// Refuses what is not there.
pub(super) fn check(
    supervisor: &Supervisor,
    cells: &Cells,
    wanted: &RecordingRequest,
) -> Result<(), RpcError> {
    for name in &wanted.ports {
        let subject = name
            .parse()
            .map_err(|error: NoAddress| RpcError::bad_input(error.to_string()).place("/ports"))?;
        match subject {
            Subject::Component(name) if name == EVENTS => {}
            Subject::Component(name) if cells.of(&name).is_some() => {}
            Subject::Component(name) => {
                components::find(&supervisor.components, &name)?;
            }
            // A cell itself refuses a port that it has not.
            Subject::Port(address) if cells.of(&address.component).is_some() => {}
            Subject::Port(address) => {
                let hosted = components::find(&supervisor.components, &address.component)?;
                ports::find(&hosted, &address.port)?;
            }
        }
    }
    Ok(())
}

/// Begins a recording of all processes; it ends when nobody takes its frames any more, and `held` is
/// dropped then. Returns the number of the last change before it, too.
pub(super) async fn begin(
    supervisor: Arc<Supervisor>,
    cells: &Cells,
    wanted: RecordingRequest,
    held: impl Send + 'static,
) -> Result<(mpsc::Receiver<Vec<u8>>, u64), RpcError> {
    let in_cells = cells.record(&wanted).await.map_err(rpc::cells::refused)?;
    let apart = in_cells.apart();
    let (sender, mut receiver) = mpsc::channel(WAITING);
    if !in_cells.is_empty() {
        let (merged, all) = mpsc::channel(WAITING);
        tokio::spawn(in_cells.join_frames(std::mem::replace(&mut receiver, all), merged));
    }
    let (changes, after) = supervisor.bus.live_after();
    tokio::task::spawn_blocking(move || {
        let session = supervisor.record(wanted, apart);
        let start = Start {
            recording: session.number,
            genomd: env!("CARGO_PKG_VERSION").to_owned(),
            clock: clock::kind(&supervisor.clock),
            deployment: toml::to_string(&supervisor.dump()).unwrap_or_default(),
        };
        recording::run(&supervisor.closed, &session, changes, sender, start);
        supervisor.recording_ended(&session);
        drop(held);
    });
    Ok((receiver, after))
}

/// End a recording, after all samples taken until now are sent.
#[utoipa::path(
    delete,
    path = "/recordings/{number}",
    tag = "recordings",
    responses((status = 200, body = RecordingEnds), (status = 404))
)]
pub(crate) async fn end(
    State(daemon): State<Arc<Daemon>>,
    Path(number): Path<String>,
) -> Result<Json<RecordingEnds>, RpcError> {
    // Those that the daemon keeps end by their names, which takes another right.
    let streamed = |number: &u64| !daemon.kept.has(*number);
    let number_of = number.parse().ok().filter(streamed);
    let ended = number_of.is_some_and(|number| daemon.supervisor.recordings.end(number));
    if ended {
        return Ok(Json(RecordingEnds { ends: true }));
    }
    let message = format!("there is no recording `{number}`");
    Err(RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchRecording, message))
}
