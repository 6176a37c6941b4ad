//! The clock that components live by, and its steps when it is virtual.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use genom_runtime::Clock;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;

/// Longest step, in seconds: a longer one is several.
const LONGEST: u64 = 3600;

/// A step of a virtual clock.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Step {
    /// How far to go, in nanoseconds. 0 runs what is pending now.
    #[schema(maximum = 3_600_000_000_000_i64)]
    #[serde(deserialize_with = "whole")]
    nanoseconds: u64,
}

/// A whole number, however it is written: `2.0` is one too in JSON.
fn whole<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    let number = serde_json::Number::deserialize(from)?;
    let real = number.as_f64().filter(|real| real.fract() == 0.0 && (0.0..1e18).contains(real));
    number
        .as_u64()
        .or(real.map(|real| real as u64))
        .ok_or_else(|| D::Error::custom(format_args!("{number} is no number of nanoseconds")))
}

/// The clock.
#[derive(Serialize, ToSchema)]
pub(crate) struct Told {
    /// `monotonic`, that of the machine, or `virtual`.
    clock: &'static str,
    /// Its date, in nanoseconds.
    now: u64,
}

/// Tell which clock components live by, and its date.
#[utoipa::path(
    get,
    path = "/clock",
    tag = "clock",
    security(("token" = ["read"])),
    responses((status = 200, body = Told))
)]
pub(crate) async fn look(State(daemon): State<Arc<Daemon>>) -> Json<Told> {
    Json(told(&daemon.clock))
}

/// Advance a virtual clock, and answer when everything on the way was run.
#[utoipa::path(
    post,
    path = "/clock",
    tag = "clock",
    security(("token" = ["call"])),
    request_body = Step,
    responses((status = 200, body = Told), (status = 409), (status = 422))
)]
pub(crate) async fn step(
    State(daemon): State<Arc<Daemon>>,
    Body(Step { nanoseconds }): Body<Step>,
) -> Result<Json<Told>, RpcError> {
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

fn told(clock: &Clock) -> Told {
    let kind = if matches!(clock, Clock::Virtual(_)) { "virtual" } else { "monotonic" };
    Told { clock: kind, now: clock.now() }
}
