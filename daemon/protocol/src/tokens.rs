//! Tokens: they identify clients that do not use the Unix socket, and carry their rights.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::Right;

/// Content of a daemon's token file.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TokenFile {
    /// `[[token]]`
    #[serde(default)]
    pub token: Vec<TokenEntry>,
}

/// A token. Its debug output does not contain the secret.
#[derive(Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TokenEntry {
    /// Name of the token's holder.
    pub name: String,
    /// The secret text.
    pub token: String,
    /// What its holder may do.
    pub rights: Vec<Right>,
}

impl fmt::Debug for TokenEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.name, self.rights)
    }
}

/// The token file was read again.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Reloaded {
    /// Number of tokens it contains.
    pub tokens: usize,
}
