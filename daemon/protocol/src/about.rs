//! The daemon itself: what it is, whether it is ready, its end.

use serde::{Deserialize, Serialize};

/// What this daemon is.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct About {
    /// Its version.
    pub genomd: String,
    /// Its process.
    pub pid: u32,
    /// Its default middleware.
    pub backend: String,
    /// TCP address it listens on as well.
    pub listen: Option<String>,
    /// Where its interface is described.
    pub openapi: String,
}

/// A daemon that was asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Stopping {
    /// It does.
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
    /// Answer when it is so, or after so many seconds.
    #[cfg_attr(feature = "openapi", param(minimum = 0))]
    pub wait: Option<f64>,
    /// Ready is it only with the connections, calls and activities of its configuration made.
    pub deployed: Option<bool>,
}

/// The daemon is ready.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Ready {
    /// It is.
    pub ready: bool,
    /// Whether connections, calls and activities of its configuration are made, too.
    pub deployed: bool,
}
