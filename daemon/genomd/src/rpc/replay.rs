//! Publishes samples of a recording to in ports.

use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use genom_doors::RpcError;
use genom_protocol::address::NoAddress;
use genom_protocol::{Address, Replayed, replay};
use genom_supervisor::Supervisor;
use genom_supervisor::connections::feed::FeedError;

use crate::rpc::{components, ports};

/// Publish samples of a recording to in ports, each `length: u32, in port, length: u32, CDR`,
/// little endian. The CDR has its encapsulation header.
///
/// Replies when all are published. If one is refused, the samples before it were published.
#[utoipa::path(
    post,
    path = "/replay",
    tag = "recordings",
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
    State(supervisor): State<Arc<Supervisor>>,
    bytes: Bytes,
) -> Result<Json<Replayed>, RpcError> {
    let work = tokio::task::spawn_blocking(move || {
        let (mut rest, mut published) = (&bytes[..], 0_u64);
        while !rest.is_empty() {
            let misshapen = || RpcError::bad_input("half a sample").place(published.to_string());
            let (inport, message, left) = replay::first(rest).ok_or_else(misshapen)?;
            one(&supervisor, inport, message)?;
            (rest, published) = (left, published + 1);
        }
        Ok(Json(Replayed { published }))
    });
    work.await.unwrap_or_else(|error| Err(RpcError::internal(error.to_string())))
}

fn one(supervisor: &Supervisor, inport: &str, message: &[u8]) -> Result<(), RpcError> {
    let parsed = inport.parse();
    let Address { component, port, element } =
        parsed.map_err(|error: NoAddress| RpcError::bad_input(error.to_string()))?;
    let hosted = components::find(&supervisor.components, &component)?;
    let key = ports::key(&hosted, &port, element)?;
    let fill = |value: &mut genom_types::Record| Ok::<_, FeedError>(value.decode_message(message)?);
    let fed = supervisor.connections.feed(&hosted, &key, fill, |_| ());
    fed.map_err(|error| ports::not_published(&error).place(inport))
}
