//! Section `[reload]`: how long the library of a reload is on trial, and what takes it back.

use serde::{Deserialize, Serialize};

/// Section `[reload]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReloadSection {
    /// Ticks that each periodic task makes during a trial.
    pub ticks: u64,
    /// Whether an activity that ends with an exception during a trial takes the library back.
    pub exceptions: bool,
}

impl Default for ReloadSection {
    fn default() -> Self {
        Self { ticks: 100, exceptions: false }
    }
}
