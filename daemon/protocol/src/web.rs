//! The web console: links that open it.

use serde::{Deserialize, Serialize};

use crate::Right;

/// A link to make.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LinkRequest {
    /// Rights of whoever opens the link; by default all those of the client that asks for it, which
    /// cannot give others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rights: Option<Vec<Right>>,
}

/// A link that opens the web console once.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Link {
    /// The address, with the one-time token after `#`.
    pub url: String,
    /// Seconds within which it has to be opened.
    pub seconds: f64,
}
