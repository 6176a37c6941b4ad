//! A finding: what was inspected, how severe it is, and what to do about it.

use serde::Serialize;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Level {
    /// Nothing is wrong.
    Ok,
    /// Costs performance under load, or matters for some uses only.
    Note,
    /// Something will not work.
    Problem,
}

/// Result of inspecting one thing.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Finding {
    /// What was inspected.
    pub(crate) about: &'static str,
    pub(crate) level: Level,
    /// What was found.
    pub(crate) what: String,
    /// What the user can do; `None` if nothing is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) fix: Option<String>,
}

impl Finding {
    pub(crate) fn ok(about: &'static str, what: impl Into<String>) -> Self {
        Self { about, level: Level::Ok, what: what.into(), fix: None }
    }

    pub(crate) fn note(
        about: &'static str,
        what: impl Into<String>,
        fix: impl Into<String>,
    ) -> Self {
        Self { about, level: Level::Note, what: what.into(), fix: Some(fix.into()) }
    }

    pub(crate) fn problem(
        about: &'static str,
        what: impl Into<String>,
        fix: impl Into<String>,
    ) -> Self {
        Self { about, level: Level::Problem, what: what.into(), fix: Some(fix.into()) }
    }
}
