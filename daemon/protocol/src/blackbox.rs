//! The black box: what is kept of the last seconds, outside the processes that it happened in.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// How the black box is.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct BlackBox {
    /// Whether anything is kept.
    pub enabled: bool,
    /// Seconds that a file reaches back.
    pub seconds: f64,
    /// What makes it write a file: `crash`, `exception`, `supervision`.
    pub on: Vec<String>,
    /// The directory of files, but for those of crashes; absent if there is no place for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub directory: Option<PathBuf>,
    /// What is kept of each process.
    pub processes: Vec<BlackBoxPart>,
    /// The files in the directory, the newest first.
    pub files: Vec<BlackBoxFile>,
    /// Reasons for which no file was written, since one was a moment before.
    pub skipped: u64,
    /// Patterns of the configuration that match nothing that runs.
    pub unmatched: Vec<String>,
}

/// What is kept of one process.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct BlackBoxPart {
    /// The cell; absent for the daemon itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// Ports and subjects (calls, activities, exceptions, changes) that are kept.
    pub tracks: u64,
    /// Bytes of what is kept, and the most that they may be.
    pub bytes: u64,
    /// As above.
    pub most_bytes: u64,
    /// Memory that it takes, in bytes.
    pub memory: u64,
    /// Samples and events taken so far, and those that were too large to be kept.
    pub taken: u64,
    /// As above.
    pub refused: u64,
}

/// A file that a black box wrote.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct BlackBoxFile {
    /// Its name.
    pub name: String,
    /// Its size.
    pub bytes: u64,
}

/// What a black box wrote.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct BlackBoxLeft {
    /// The file.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub file: PathBuf,
    /// Messages in it.
    pub messages: u64,
    /// Topics that do not reach back as far as they should, since memory was short.
    pub short: u64,
    /// Why it is not there, or not complete.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}
