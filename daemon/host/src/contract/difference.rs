//! Differences between a library and its description.

/// A codel or type that is different in the library and in the description.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{subject} ({place}): {why}\n  .gen:    {description}\n  library: {library}")]
pub struct Difference {
    /// The codel or exception.
    pub subject: String,
    /// Where the `.gen` declares it: file and line.
    pub place: String,
    /// The difference, in a few words.
    pub why: String,
    /// The declaration in the description.
    pub description: String,
    /// The declaration in the library.
    pub library: String,
}
