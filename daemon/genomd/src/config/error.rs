//! What is wrong with a configuration, and where.

use std::path::PathBuf;

/// A configuration file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ConfigError {
    /// Missing or unreadable.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A mistake in it.
    #[error("{}:{line}: {message}{}", path.display(), suggestion(.nearest))]
    Mistake { path: PathBuf, line: usize, message: String, nearest: Option<String> },
    /// A mistake in `--set`.
    #[error("--set {word}: {why}")]
    Set { word: String, why: String },
}

/// A file describes several daemons, and which of them is meant is not said, or is none of them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}; say with --daemon which of these it is: {}", wrong(.given.as_deref()), names.join(", "))]
pub(crate) struct WhichDaemon {
    pub(super) given: Option<String>,
    pub(super) names: Vec<String>,
}

fn wrong(given: Option<&str>) -> String {
    match given {
        Some(given) => format!("the file describes no daemon `{given}`"),
        None => "the file describes several daemons".to_owned(),
    }
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}
