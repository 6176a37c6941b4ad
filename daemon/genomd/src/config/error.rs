//! What is wrong with a configuration, and where.

use std::path::PathBuf;

use crate::nearest::nearest;

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

/// Serde says ``unknown field `x`, expected one of `a`, `b` ``: the nearest of what it expects.
pub(crate) fn nearest_key(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = message.starts_with("unknown field").then(|| quoted.next()).flatten()?;
    nearest(unknown, quoted).map(str::to_owned)
}
