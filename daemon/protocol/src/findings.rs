//! Why no data flows through a port.

use serde::{Deserialize, Serialize};

use crate::is_false;

/// What keeps data from flowing.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Findings {
    /// None: data flows.
    pub findings: Vec<Finding>,
    /// The port and its elements that data flows through, whatever else is found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flows: Vec<String>,
}

/// One reason, and what to do.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Finding {
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub fix: String,
    /// Whether both ends are there and still do not meet: a mistake, whatever the port is for.
    #[serde(default, skip_serializing_if = "is_false")]
    pub unmet: bool,
}
