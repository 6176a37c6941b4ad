//! What a library and its description do not agree on.

/// A codel or type that the library and the description see differently.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{subject} ({place}): {why}\n  .gen:    {description}\n  library: {library}")]
pub struct Difference {
    /// The codel or exception.
    pub subject: String,
    /// Where the `.gen` declares it: file and line.
    pub place: String,
    /// The difference in a few words.
    pub why: String,
    /// What the description says.
    pub description: String,
    /// What the library says.
    pub library: String,
}
