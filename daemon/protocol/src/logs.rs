//! What the daemon logged, and logs.

use serde::{Deserialize, Serialize};
use strum::{Display, EnumString, IntoStaticStr, VariantNames};

/// How grave an entry is; the gravest is the least.
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
    /// This level and graver ones.
    #[cfg_attr(feature = "openapi", param(pattern = "^(error|warn|info|debug|trace)$"))]
    pub level: Option<String>,
    /// What is about this component.
    pub component: Option<String>,
    /// At most so many entries, the latest; in a stream, so many before it starts.
    pub last: Option<usize>,
}

/// What was logged.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Logs {
    /// Oldest first.
    pub logs: Vec<LogEntry>,
}

/// An entry of the log.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LogEntry {
    /// Seconds since 1970.
    pub time: f64,
    /// How grave it is.
    pub level: Level,
    /// Part of the daemon that logged it.
    pub origin: String,
    /// The component it is about, if it is about one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<String>,
    /// What happened.
    pub message: String,
}
