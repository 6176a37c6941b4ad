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

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}
