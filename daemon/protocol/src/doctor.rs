//! What keeps components from running well: findings about a machine and its daemon.

use serde::{Deserialize, Serialize};

use crate::{Remedy, is_false};

/// `?daemon_only=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct DoctorParameters {
    /// Leave the machine out.
    #[serde(default, skip_serializing_if = "is_false")]
    pub daemon_only: bool,
}

/// What was found.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Examined {
    /// About the machine of the daemon; empty if it was left out.
    pub machine: Vec<Diagnosis>,
    /// About the daemon, its cells and components.
    pub daemon: Vec<Diagnosis>,
}

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Severity {
    /// Nothing is wrong.
    Ok,
    /// Costs performance under load, or matters for some uses only.
    Note,
    /// Something will not work.
    Problem,
}

/// Result of inspecting one thing.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Diagnosis {
    /// What was inspected.
    pub about: String,
    /// How much it matters.
    pub level: Severity,
    /// What was found.
    pub what: String,
    /// What the user can do; absent if nothing is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fix: Option<String>,
    /// What the daemon can do about it when it is asked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remedies: Vec<Remedy>,
}

impl Diagnosis {
    /// Nothing is wrong.
    #[must_use]
    pub fn ok(about: &str, what: impl Into<String>) -> Self {
        let (about, what) = (about.to_owned(), what.into());
        Self { about, level: Severity::Ok, what, fix: None, remedies: Vec::new() }
    }

    /// Something that matters for some uses only.
    #[must_use]
    pub fn note(about: &str, what: impl Into<String>, fix: impl Into<String>) -> Self {
        Self { level: Severity::Note, fix: Some(fix.into()), ..Self::ok(about, what) }
    }

    /// Something that will not work.
    #[must_use]
    pub fn problem(about: &str, what: impl Into<String>, fix: impl Into<String>) -> Self {
        Self { level: Severity::Problem, fix: Some(fix.into()), ..Self::ok(about, what) }
    }

    /// The same with a request that may help.
    #[must_use]
    pub fn or(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }
}
