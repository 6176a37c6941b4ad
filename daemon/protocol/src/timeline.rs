//! The changes of the last minutes with their dates.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// `?component=NAME`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct TimelineParameters {
    /// Only changes of this component, and those of none.
    pub component: Option<String>,
}

/// Data of an event `changes`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Timeline {
    /// Whether this is the first event of the stream: it begins with what is kept.
    pub first: bool,
    /// In the order in which they happened.
    pub changes: Vec<Dated>,
    /// The time now, in nanoseconds since 1970, or of the virtual clock.
    pub now: u64,
    /// Since when all changes are kept.
    pub since: u64,
    /// Changes since the event before that are not here, because the client did not take them.
    pub missed: u64,
}

/// A change with its date.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Dated {
    /// When the daemon was told of it, in nanoseconds as `now`.
    pub at: u64,
    /// A [`Change`](crate::Change).
    #[cfg_attr(feature = "openapi", schema(value_type = crate::Change))]
    pub change: Value,
}
