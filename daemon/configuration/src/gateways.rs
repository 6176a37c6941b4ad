//! Section `[gateways]`: middlewares that run in processes of their own.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[gateways]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GatewaysSection {
    /// Names of these middlewares.
    pub of: Vec<String>,
    /// Socket of the daemon that starts them; by default this daemon's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub daemon: Option<PathBuf>,
}

impl GatewaysSection {
    /// Checks that there can be gateways of these middlewares.
    ///
    /// # Errors
    /// One is unknown, or does not leave this machine.
    pub fn check(&self) -> Result<(), UsageError> {
        let each = self.of.iter().try_for_each(|name| genom_registry::check_gateway(name));
        each.map_err(|error| UsageError::Gateway(error.to_string()))
    }
}
