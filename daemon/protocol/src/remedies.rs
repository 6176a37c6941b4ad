//! What the daemon itself can do about a finding: requests that a client may make for its user.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::Right;

/// A request that may help, for a client to offer.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Remedy {
    /// What it does: `Unload demo`.
    pub does: String,
    /// Its method: `DELETE`.
    pub method: String,
    /// Its path: `/components/demo`.
    pub path: String,
    /// Its body; absent if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Object>))]
    pub body: Option<Value>,
    /// The right that it takes.
    pub right: Right,
    /// What the user has to choose first; absent if nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choose: Option<Choice>,
}

/// What is missing in the body of a remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Choice {
    /// Member `out`: the address of an out port whose type is that of the in port in member `in`.
    OutPort,
}
