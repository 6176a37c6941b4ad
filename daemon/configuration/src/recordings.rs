//! Section `[recordings]`: where the daemon keeps recordings that it makes itself, and how many.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::states::state;

/// Section `[recordings]`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingsSection {
    /// The directory; by default one in the user's directory of states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<PathBuf>,
    /// Recordings that are kept; none is begun above that. With 0, the daemon makes none.
    pub most: usize,
    /// Size of all of them together, in bytes; recordings end there.
    pub most_bytes: u64,
}

impl Default for RecordingsSection {
    fn default() -> Self {
        Self { directory: None, most: 100, most_bytes: 4_294_967_296 }
    }
}

impl RecordingsSection {
    /// The directory: the one configured, else `genomd/recordings` in `$XDG_STATE_HOME`, else in
    /// `~/.local/state`; `None` without any of them.
    #[must_use]
    pub fn place(&self) -> Option<PathBuf> {
        self.directory.clone().or_else(|| Some(state()?.join("genomd/recordings")))
    }
}
