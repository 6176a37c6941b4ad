//! Activities: the running ones, and those that ended recently.

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
    /// Wait until the activity has ended, at most this many seconds.
    #[cfg_attr(feature = "openapi", param(minimum = 0))]
    pub wait: Option<f64>,
}

/// The activities of a component, in order of their numbers.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Activities {
    /// Running activities, and ended ones whose results are still kept.
    pub activities: Vec<Activity>,
}

/// An activity that runs or ended recently.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Activity {
    /// Its number, unique during the life of the component.
    pub activity: u64,
    /// Name of its service.
    pub service: String,
    /// Whether it runs, or how it ended.
    pub status: Status,
    /// State that it is in, or `waiting` before it starts; only while it runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// Its result or exception; only after it ended.
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

/// The activities of one component that were asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Aborted {
    /// Their numbers.
    pub aborted: Vec<u64>,
}

/// The activities of all components that were asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AllAborted {
    /// Those that were running.
    pub aborted: Vec<AbortedActivity>,
}

/// An activity that was asked to stop.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct AbortedActivity {
    /// Name of the instance that runs it.
    pub component: String,
    /// Name of its service.
    pub service: String,
    /// Its number.
    pub activity: u64,
}
