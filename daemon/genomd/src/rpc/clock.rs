//! The clock that components live by, and its steps when it is virtual.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use genom_runtime::Clock;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;

/// Longest step, in seconds: a longer one is several.
const LONGEST: u64 = 3600;

/// Body of a step.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Step {
    /// How far to go, in nanoseconds. 0 runs what is pending now.
    nanoseconds: u64,
}

/// `GET /clock`: which clock it is, and its date in nanoseconds.
pub(crate) async fn look(State(daemon): State<Arc<Daemon>>) -> Json<Value> {
    Json(told(&daemon.clock))
}

/// `POST /clock`: advances a virtual clock, and answers when everything on the way was run.
pub(crate) async fn step(
    State(daemon): State<Arc<Daemon>>,
    Body(Step { nanoseconds }): Body<Step>,
) -> Result<Json<Value>, RpcError> {
    let Clock::Virtual(clock) = daemon.clock.clone() else {
        let message = "this daemon lives by the machine's clock, which nobody steps";
        return Err(RpcError::conflict("monotonic_clock", message)
            .help("start it with `genomd --clock virtual`"));
    };
    let duration = Duration::from_nanos(nanoseconds);
    if duration > Duration::from_secs(LONGEST) {
        let message = format!("a step of {duration:?} is too long: {LONGEST} s are the most");
        return Err(RpcError::bad_input(message).place("/nanoseconds"));
    }
    // Codels run in the thread that steps.
    tokio::task::spawn_blocking(move || clock.step(duration))
        .await
        .map_err(|error| RpcError::internal(error.to_string()))?;
    Ok(Json(told(&daemon.clock)))
}

fn told(clock: &Clock) -> Value {
    let kind = if matches!(clock, Clock::Virtual(_)) { "virtual" } else { "monotonic" };
    json!({"clock": kind, "now": clock.now()})
}
