//! Section `[crashes]`: where reports of cells that crashed are kept, and how many.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::states::state;

/// Section `[crashes]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct CrashesSection {
    /// The directory of the reports; by default one in the user's directory of states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<PathBuf>,
    /// Reports that are kept; above that, the cell with the most loses its oldest. With 0, none are
    /// written.
    pub most: usize,
    /// Size of all of them together, in bytes.
    pub most_bytes: u64,
    /// Whether cells leave core dumps, as the system is configured.
    pub core: bool,
    /// Whether a minidump of the process is put into the report of a crash.
    pub minidump: bool,
}

impl Default for CrashesSection {
    fn default() -> Self {
        Self { directory: None, most: 20, most_bytes: 67_108_864, core: false, minidump: false }
    }
}

impl CrashesSection {
    /// The directory: the one configured, else `genomd/crashes` in `$XDG_STATE_HOME`, else in
    /// `~/.local/state`; `None` without any of them.
    #[must_use]
    pub fn place(&self) -> Option<PathBuf> {
        self.directory.clone().or_else(|| Some(state()?.join("genomd/crashes")))
    }
}
