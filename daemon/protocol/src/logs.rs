//! The log of the daemon.

use serde::{Deserialize, Serialize};
use strum::{Display, EnumString, IntoStaticStr, VariantNames};

/// Severity of an entry, the most severe first.
#[derive(
    Clone,
    Copy,
    Debug,
    Display,
    EnumString,
    IntoStaticStr,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Deserialize,
    Serialize,
    VariantNames,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[allow(missing_docs, reason = "levels are known by their names; docs would show in --help")]
pub enum Level {
    Error,
    Warn,
    Info,
    Debug,
    Trace,
}

/// `?level=LEVEL&component=NAME&last=COUNT`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct LogParameters {
    /// Only entries of this level, and more severe ones.
    #[cfg_attr(feature = "openapi", param(pattern = "^(error|warn|info|debug|trace)$"))]
    pub level: Option<String>,
    /// Only entries about this component.
    pub component: Option<String>,
    /// Maximum number of entries: the latest ones; for a stream, how many to send before it starts.
    pub last: Option<usize>,
}

/// Entries of the log.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Logs {
    /// The entries, oldest first.
    pub logs: Vec<LogEntry>,
}

/// An entry of the log.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LogEntry {
    /// When it was logged, in seconds since 1970.
    pub time: f64,
    /// Its severity.
    pub level: Level,
    /// Module of the daemon that logged it.
    pub origin: String,
    /// Its source file, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The line in that file, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// The component it is about, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<String>,
    /// The message.
    pub message: String,
}

impl LogEntry {
    /// When it was logged, as `12:34:56.789` in UTC.
    #[must_use]
    pub fn time_of_day(&self) -> String {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a date")]
        let milliseconds = (self.time * 1e3) as u64;
        let (seconds, rest) = (milliseconds / 1000, milliseconds % 1000);
        let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
        format!("{hour:02}:{minute:02}:{second:02}.{rest:03}")
    }
}
