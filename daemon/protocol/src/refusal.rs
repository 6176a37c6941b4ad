//! The form of all errors: `{"error": {"code", "message", "where", "help"}}`.

use serde::{Deserialize, Serialize};

use crate::Code;

/// The body of every error response.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Refusal {
    /// The reason.
    pub error: Reason,
}

/// Why a request was refused. The request changed nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reason {
    /// Stable name of the reason: a [`Code`], or a name that a later daemon added.
    #[serde(default)]
    #[cfg_attr(feature = "openapi", schema(value_type = Code))]
    pub code: String,
    /// The reason as one sentence.
    pub message: String,
    /// Where in the request: a JSON pointer into the body, or a parameter.
    #[serde(default, rename = "where", skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// What the user can do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Reason {
    /// A reason without place and help.
    #[must_use]
    pub fn new(code: impl AsRef<str>, message: impl Into<String>) -> Self {
        Self { code: code.as_ref().to_owned(), message: message.into(), ..Self::default() }
    }

    /// Whether the reason has this code.
    #[must_use]
    pub fn is(&self, code: Code) -> bool {
        self.code == code.as_ref()
    }

    /// The reason and what one can do about it, in one line.
    #[must_use]
    pub fn line(&self) -> String {
        match &self.help {
            Some(help) => format!("{}; {help}", self.message),
            None => self.message.clone(),
        }
    }
}
