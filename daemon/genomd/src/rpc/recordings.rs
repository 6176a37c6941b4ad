//! Recordings: what passes through ports and what is asked of services, as a stream of frames.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::{Body as Stream, Bytes};
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use genom_runtime::Clock;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tokio::sync::mpsc;
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::ReceiverStream;
use utoipa::ToSchema;

use crate::daemon::Daemon;
use crate::deploy;
use crate::recording;
use crate::rpc::error::RpcError;
use crate::rpc::holder::Holder;
use crate::rpc::input::Body;
use crate::rpc::{components, ports, stream};

/// Batches that wait to be sent.
const WAITING: usize = 4;

/// A recording that ends.
#[derive(Serialize, ToSchema)]
pub(crate) struct Ends {
    /// It does.
    ends: bool,
}

/// What to record.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// Components, ports, elements of multiple ports; everything when empty.
    #[serde(default)]
    ports: Vec<String>,
}

/// Record ports and what services are asked; the answer is the recording, as it comes, in frames
/// (`length: u32, kind: u8, content`, little endian).
#[utoipa::path(
    post,
    path = "/recordings",
    tag = "recordings",
    security(("token" = ["read"])),
    request_body = Wanted,
    responses(
        (status = 200, content_type = "application/octet-stream", body = Vec<u8>),
        (status = 404),
        (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn start(
    State(daemon): State<Arc<Daemon>>,
    Extension(holder): Extension<Holder>,
    Body(wanted): Body<Wanted>,
) -> Result<Response, RpcError> {
    for name in &wanted.ports {
        let mut parts = name.split('/');
        let hosted = components::find(&daemon, parts.next().unwrap_or_default())?;
        if let Some(port) = parts.next() {
            ports::find(&hosted, port)?;
        }
    }
    let slot = stream::slot(&daemon, &holder)?;
    let (sender, receiver) = mpsc::channel(WAITING);
    tokio::task::spawn_blocking(move || {
        let changes = daemon.bus.live();
        let session = daemon.record(wanted.ports);
        let start = json!({
            "recording": session.number,
            "genomd": env!("CARGO_PKG_VERSION"),
            "clock": if matches!(daemon.clock, Clock::Virtual(_)) { "virtual" } else { "monotonic" },
            "deployment": toml::to_string(&deploy::dump::dump(&daemon)).unwrap_or_default(),
        });
        recording::run(&daemon.closed, &session, changes, sender, &start);
        daemon.recording_ended(&session);
        drop(slot);
    });
    let batches =
        ReceiverStream::new(receiver).map(|batch| Ok::<_, Infallible>(Bytes::from(batch)));
    let kind = [(header::CONTENT_TYPE, "application/octet-stream")];
    Ok((kind, Stream::from_stream(batches)).into_response())
}

/// End a recording, once all is sent that was taken until now.
#[utoipa::path(
    delete,
    path = "/recordings/{number}",
    tag = "recordings",
    security(("token" = ["read"])),
    responses((status = 200, body = Ends), (status = 404))
)]
pub(crate) async fn end(
    State(daemon): State<Arc<Daemon>>,
    Path(number): Path<String>,
) -> Result<Json<Ends>, RpcError> {
    let ended = number.parse().is_ok_and(|number| daemon.recordings.end(number));
    if ended {
        return Ok(Json(Ends { ends: true }));
    }
    let message = format!("there is no recording `{number}`");
    Err(RpcError::new(StatusCode::NOT_FOUND, "no_such_recording", message))
}
