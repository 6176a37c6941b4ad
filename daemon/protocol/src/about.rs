//! The daemon itself: what it is, whether it is ready, its end.

use serde::{Deserialize, Serialize};

/// The daemon: version, process, addresses.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct About {
    /// Version of genomd.
    pub genomd: String,
    /// Process identifier.
    pub pid: u32,
    /// Name of its default middleware.
    pub backend: String,
    /// TCP address that it listens on besides its Unix socket.
    pub listen: Option<String>,
    /// Path of its OpenAPI document.
    pub openapi: String,
}

/// The daemon was asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Stopping {
    /// Always true.
    pub stopping: bool,
}

/// `?wait=SECONDS&deployed=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct ReadyParameters {
    /// Wait until the daemon is ready, at most this many seconds.
    #[cfg_attr(feature = "openapi", param(minimum = 0))]
    pub wait: Option<f64>,
    /// Count the daemon as ready only when the connections, calls and activities of its
    /// configuration are made, too.
    pub deployed: Option<bool>,
}

/// The daemon is ready.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Ready {
    /// Always true: a daemon that is not ready refuses the request.
    pub ready: bool,
    /// Whether the connections, calls and activities of its configuration are made.
    pub deployed: bool,
}
