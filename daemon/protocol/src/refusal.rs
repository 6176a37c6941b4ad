//! The one shape of errors: `{"error": {"code", "message", "where", "help"}}`.

use serde::{Deserialize, Serialize};

use crate::Code;

/// The body of every refusal.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Refusal {
    /// Why.
    pub error: Reason,
}

/// Why a request was refused. Nothing was changed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reason {
    /// Stable name of the reason: a [`Code`], or one of a later daemon.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(value_type = Code))]
    pub code: String,
    /// One sentence.
    pub message: String,
    /// Place in the request: a JSON pointer into the body, or a parameter.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// The way out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Reason {
    /// A reason with neither a place nor a way out.
    #[must_use]
    pub fn new(code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self { code: code.as_ref().to_owned(), message: message.into(), ..Self::default() }
    }

    /// Whether this is the reason.
    #[must_use]
    pub fn is(&self, code: Code) -> bool {
        self.code == code.as_ref()
    }
}
