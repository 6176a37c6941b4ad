//! Publishes samples of a recording to in ports.

use std::sync::Arc;

use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use genom_cells::{Cell, Cells};
use genom_doors::RpcError;
use genom_protocol::address::NoAddress;
use genom_protocol::{Address, Replayed, component_of, replay};
use genom_supervisor::Supervisor;
use genom_supervisor::connections::feed::FeedError;

use crate::rpc::{self, components, ports};

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
    State(cells): State<Arc<Cells>>,
    bytes: Bytes,
) -> Result<Json<Replayed>, RpcError> {
    all(&supervisor, &cells, bytes).await.map(|published| Json(Replayed { published }))
}

/// Publishes samples, those for components in cells there; how many were published.
pub(super) async fn all(
    supervisor: &Arc<Supervisor>,
    cells: &Cells,
    bytes: Bytes,
) -> Result<u64, RpcError> {
    let (mut at, mut published) = (0, 0_u64);
    while at < bytes.len() {
        let (cell, length) = run(&bytes[at..], |component| cells.of(component))
            .ok_or_else(|| RpcError::bad_input("half a sample").place(published.to_string()))?;
        let piece = bytes.slice(at..at + length);
        published += match cell {
            Some(cell) => {
                let told = cell.publish(piece).await.map_err(rpc::cells::not_done)?;
                told.published
            }
            None => {
                let supervisor = Arc::clone(supervisor);
                let work = tokio::task::spawn_blocking(move || here(&supervisor, &piece));
                work.await.unwrap_or_else(|error| Err(RpcError::internal(error.to_string())))?
            }
        };
        at += length;
    }
    Ok(published)
}

/// The process of the first sample, and how many bytes have its samples until the next process. Only
/// whole samples count; `None` if the first is not.
fn run(bytes: &[u8], of: impl Fn(&str) -> Option<Arc<Cell>>) -> Option<(Option<Arc<Cell>>, usize)> {
    let cell_of = |inport: &str| of(component_of(inport));
    let (inport, _, mut rest) = replay::first(bytes)?;
    let cell = cell_of(inport);
    while let Some((inport, _, after)) = replay::first(rest) {
        let same = match (&cell, &cell_of(inport)) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (one, other) => one.is_none() && other.is_none(),
        };
        if !same {
            break;
        }
        rest = after;
    }
    Some((cell, bytes.len() - rest.len()))
}

fn here(supervisor: &Supervisor, mut rest: &[u8]) -> Result<u64, RpcError> {
    let mut published = 0;
    while let Some((inport, message, left)) = replay::first(rest) {
        one(supervisor, inport, message)?;
        (rest, published) = (left, published + 1);
    }
    Ok(published)
}

fn one(supervisor: &Supervisor, inport: &str, message: &[u8]) -> Result<(), RpcError> {
    let parsed = inport.parse();
    let Address { component, port, element } =
        parsed.map_err(|error: NoAddress| RpcError::bad_input(error.to_string()))?;
    let hosted = components::find(&supervisor.components, &component)?;
    let key = ports::key(&hosted, &port, element)?;
    let fill = |value: &mut genom_types::Record| Ok::<_, FeedError>(value.decode_message(message)?);
    let fed = supervisor.connections.feed(&hosted, &key, fill, |_| ());
    fed.map_err(|error| genom_views::not_published(&error).place(inport))
}
