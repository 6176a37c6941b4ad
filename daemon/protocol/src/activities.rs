//! Activities: those that run and those that ended lately.

use serde::{Deserialize, Serialize};
use strum::Display;

use crate::Outcome;

/// `?wait=SECONDS`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct LookParameters {
    /// Answer when the activity has ended, or after so many seconds.
    #[cfg_attr(feature = "openapi", param(minimum = 0))]
    pub wait: Option<f64>,
}

/// Activities of a component, by number.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Activities {
    /// Running ones, and those whose results are still kept.
    pub activities: Vec<Activity>,
}

/// An activity that runs, or ended lately.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Activity {
    /// Its number, unique in the component's life.
    pub activity: u64,
    /// The service it runs.
    pub service: String,
    /// Whether it runs, or how it ended.
    pub status: Status,
    /// State it is in, or `waiting` before it starts; of one that runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// How it ended; of one that ended.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// Whether an activity runs, and how it ended.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Status {
    /// It runs.
    Running,
    /// It ended with its outputs.
    Done,
    /// It ended with an exception.
    Exception,
}

/// Activities of a component that were asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Aborted {
    /// Their numbers.
    pub aborted: Vec<u64>,
}

/// Activities of any components that were asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AllAborted {
    /// Those that had not ended.
    pub aborted: Vec<AbortedActivity>,
}

/// An activity that was asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AbortedActivity {
    /// Instance that runs it.
    pub component: String,
    /// The service it runs.
    pub service: String,
    /// Its number.
    pub activity: u64,
}
