//! One thing that was looked at, how grave it is, and what to do about it.

use serde::Serialize;

/// How grave a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Level {
    /// As it should be.
    Ok,
    /// Costs something under load, or in some uses.
    Note,
    /// Something will not work.
    Problem,
}

/// One thing looked at.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Finding {
    /// What was looked at.
    pub(crate) about: &'static str,
    pub(crate) level: Level,
    /// What was found.
    pub(crate) what: String,
    /// The way out; none when it is as it should be.
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
