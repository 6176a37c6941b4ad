//! What of a machine keeps components from running well, and what to do about it.
//!
//! Everything is read from files below one directory, `/` or a copy of some other machine's, so
//! that each finding can be tested; what only a live machine can tell is in `live`.

mod files;
mod live;
mod memory;

use std::path::{Path, PathBuf};

use serde::Serialize;

pub(crate) use live::live;

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

/// A machine, as its files tell it.
#[derive(Debug)]
pub(crate) struct Machine {
    root: PathBuf,
}

impl Machine {
    /// The machine whose files are below `root`.
    pub(crate) fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    fn text(&self, path: &str) -> Option<String> {
        Some(std::fs::read_to_string(self.path(path)).ok()?.trim().to_owned())
    }

    /// Everything that files tell.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        files::findings(self)
    }
}
