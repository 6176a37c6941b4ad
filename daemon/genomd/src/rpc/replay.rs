//! Samples of a recording, published to in ports.

use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use genom_middleware::Address;
use serde::Serialize;
use utoipa::ToSchema;

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::{components, ports};
use crate::wiring::connect::split;
use crate::wiring::feed::{self, FeedError};

/// The samples that were published.
#[derive(Serialize, ToSchema)]
pub(crate) struct Replayed {
    /// How many.
    published: u64,
}

/// Publish samples of a recording to in ports: `length: u32, in port, length: u32, CDR` each,
/// little endian, the CDR with its encapsulation header.
///
/// Answers when all are published, or tells which one was refused: those before it are.
#[utoipa::path(
    post,
    path = "/replay",
    tag = "recordings",
    security(("token" = ["call"])),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses(
        (status = 200, body = Replayed),
        (status = 404),
        (status = 409),
        (status = 413),
        (status = 422),
        (status = 502),
        (status = 503)
    )
)]
pub(crate) async fn publish(
    State(daemon): State<Arc<Daemon>>,
    bytes: Bytes,
) -> Result<Json<Replayed>, RpcError> {
    let work = tokio::task::spawn_blocking(move || {
        let (mut rest, mut published) = (&bytes[..], 0_u64);
        while !rest.is_empty() {
            let misshapen = || RpcError::bad_input("half a sample").place(published.to_string());
            let (inport, message, left) = cut(rest).ok_or_else(misshapen)?;
            one(&daemon, inport, message)?;
            (rest, published) = (left, published + 1);
        }
        Ok(Json(Replayed { published }))
    });
    work.await.unwrap_or_else(|error| Err(RpcError::internal(error.to_string())))
}

fn one(daemon: &Arc<Daemon>, inport: &str, message: &[u8]) -> Result<(), RpcError> {
    let address = Address::parse(inport)
        .ok_or_else(|| RpcError::bad_input(format!("`{inport}` is no COMPONENT/PORT")))?;
    let hosted = components::find(daemon, &address.instance)?;
    let (port, element) = split(&address);
    let index = ports::find(&hosted, port)?;
    let element = ports::element(&hosted, index, element.map(str::to_owned))?;
    let fill = |value: &mut genom_types::Record| Ok::<_, FeedError>(value.decode_message(message)?);
    feed::publish(daemon, &hosted, index, element.as_deref(), fill, |_| ())
        .map_err(|error| ports::not_published(&error).place(inport))
}

/// The first sample, and what follows it.
fn cut(bytes: &[u8]) -> Option<(&str, &[u8], &[u8])> {
    let (name, rest) = part(bytes)?;
    let (message, rest) = part(rest)?;
    Some((std::str::from_utf8(name).ok()?, message, rest))
}

fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}
