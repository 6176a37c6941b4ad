//! Why no data flows through a port.

use serde::{Deserialize, Serialize};

use crate::is_false;

/// The reasons why no data flows through a port.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Findings {
    /// The reasons; empty if data flows.
    pub findings: Vec<Finding>,
    /// The addresses, among the port and its elements, that data flows through, even if there are
    /// findings on others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flows: Vec<String>,
}

/// A reason, with advice.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Finding {
    /// What is wrong.
    pub what: String,
    /// What the user can do about it.
    pub fix: String,
    /// Whether both ends exist but do not reach each other. This is an error, whatever the port is
    /// used for.
    #[serde(default, skip_serializing_if = "is_false")]
    pub unmet: bool,
}
