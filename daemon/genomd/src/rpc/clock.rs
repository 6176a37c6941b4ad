//! The clock of the components, and steps of a virtual one.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use genom_cells::Cells;
use genom_doors::{Body, RpcError};
use genom_protocol::{ClockKind, StepRequest};
use genom_runtime::Clock;
use genom_supervisor::Supervisor;

use crate::rpc::cells;

/// The longest step; more time takes several steps.
const LONGEST: Duration = Duration::from_nanos(StepRequest::LONGEST);

/// Get the kind and the time of the components' clock.
#[utoipa::path(
    get,
    path = "/clock",
    tag = "clock",
    responses((status = 200, body = genom_protocol::Clock))
)]
pub(crate) async fn look(State(supervisor): State<Arc<Supervisor>>) -> Json<genom_protocol::Clock> {
    Json(now(&supervisor))
}

/// Advance the virtual clock; replies when everything that was due has run.
#[utoipa::path(
    post,
    path = "/clock",
    tag = "clock",
    request_body = StepRequest,
    responses((status = 200, body = genom_protocol::Clock), (status = 409), (status = 422))
)]
pub(crate) async fn step(
    State(supervisor): State<Arc<Supervisor>>,
    State(joined): State<Arc<Cells>>,
    Body(StepRequest { nanoseconds }): Body<StepRequest>,
) -> Result<Json<genom_protocol::Clock>, RpcError> {
    let clock = genom_views::stepped(&supervisor)?;
    let duration = Duration::from_nanos(nanoseconds);
    if duration > LONGEST {
        let message =
            format!("a step of {duration:?} is too long: {} s are the most", LONGEST.as_secs());
        return Err(RpcError::bad_input(message).place("/nanoseconds"));
    }
    joined.step(&StepRequest { nanoseconds }).await.map_err(cells::not_done)?;
    // Codels run in the thread that steps the clock.
    tokio::task::spawn_blocking(move || clock.step(duration))
        .await
        .map_err(|error| RpcError::internal(error.to_string()))?;
    Ok(Json(now(&supervisor)))
}

fn now(supervisor: &Supervisor) -> genom_protocol::Clock {
    genom_protocol::Clock { clock: supervisor.settings.clock, now: supervisor.clock.now() }
}

/// The kind of a clock, as recordings tell it.
pub(super) fn kind(clock: &Clock) -> ClockKind {
    match clock {
        Clock::Monotonic => ClockKind::Monotonic,
        Clock::Virtual(_) | Clock::Staged(_) => ClockKind::Virtual,
    }
}
