//! Recordings that the daemon makes itself and keeps in a directory.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use strum::Display;

/// The recordings that are kept, the newest first.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct KeptRecordings {
    /// Where they are; absent if there is no directory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub directory: Option<PathBuf>,
    /// How many may be there.
    pub most: usize,
    /// How large they may be together, in bytes.
    pub most_bytes: u64,
    /// How large they are together, in bytes.
    pub bytes: u64,
    /// Each of them.
    pub recordings: Vec<KeptRecording>,
}

/// A recording in the directory of the daemon.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct KeptRecording {
    /// Name of the file.
    pub file: String,
    /// How it is.
    pub state: KeptState,
    /// Size of the file, in bytes.
    pub bytes: u64,
    /// When it was last written, in seconds since 1970.
    pub written: f64,
    /// Seconds from its first sample to its last; of one under way, since it began. Absent if that is
    /// not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Samples and notes in it; absent if that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub messages: Option<u64>,
    /// Samples and notes that were lost; absent if that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost: Option<u64>,
    /// Of one under way, what is recorded; everything if empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ports: Vec<String>,
    /// Why it ended, if this daemon made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Its replay, or the last one of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replay: Option<KeptReplay>,
}

/// How a recording is.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum KeptState {
    /// It is being made.
    Recording,
    /// It has its end.
    Whole,
    /// Its end is missing: the daemon was killed while it was made. `genomctl recover` makes a whole
    /// one of it.
    Cut,
    /// It cannot be read.
    Damaged,
}

/// Has the daemon record.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct KeepRequest {
    /// Name of the file, without `.mcap`: up to 64 letters, digits, `.`, `_` and `-`; by default the
    /// date.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(pattern = "^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"))]
    pub name: Option<String>,
    /// Components, ports, and elements of multiple ports; everything if empty.
    #[serde(default)]
    pub ports: Vec<String>,
    /// Seconds after which it ends by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 0, maximum = 86400))]
    pub seconds: Option<f64>,
}

/// A recording was removed.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RecordingRemoved {
    /// Name of the file.
    pub removed: String,
}

/// Has the daemon replay a recording.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ReplayRequest {
    /// Speed relative to the recording, 0.01 to 100; by default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 0.01, maximum = 100))]
    pub rate: Option<f64>,
}

/// A recording that the daemon publishes to in ports, with its timing.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct KeptReplay {
    /// Whether it goes on.
    pub goes_on: bool,
    /// The in ports that it is published to.
    pub ports: Vec<String>,
    /// What of it is not published, with the reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Samples published so far.
    pub published: u64,
    /// Seconds of the recording that have passed.
    pub seconds: f64,
    /// Why it ended early.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}
