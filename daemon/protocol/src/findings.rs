//! Why no data flows through a port.

use serde::{Deserialize, Serialize};

use crate::{Remedy, is_false};

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
    /// The port whose findings tell more; absent if none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub see: Option<String>,
    /// What the daemon can do about it when it is asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remedies: Vec<Remedy>,
}

impl Finding {
    /// One with advice.
    #[must_use]
    pub fn new(what: impl Into<String>, fix: impl Into<String>) -> Self {
        let (what, fix) = (what.into(), fix.into());
        Self { what, fix, unmet: false, see: None, remedies: Vec::new() }
    }

    /// The same with a request that may help.
    #[must_use]
    pub fn or(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}
