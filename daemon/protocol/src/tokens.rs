//! Tokens: who may come in by other doors than the Unix socket, and what for.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::Right;

/// A daemon's token file.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TokenFile {
    /// `[[token]]`
    #[serde(default)]
    pub token: Vec<TokenEntry>,
}

/// One token. Debug output shows its name only.
#[derive(Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TokenEntry {
    /// Whose it is.
    pub name: String,
    /// The secret.
    pub token: String,
    /// What it is good for.
    pub rights: Vec<Right>,
}

impl fmt::Debug for TokenEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.name, self.rights)
    }
}

/// What the token file holds now.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reloaded {
    /// How many tokens are known.
    pub tokens: usize,
}
