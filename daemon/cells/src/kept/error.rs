//! Why a recording cannot be made, read, removed or replayed.

use std::path::PathBuf;

use genom_recording::ReadError;

use crate::shelf::ShelfError;

/// What was asked of a kept recording cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    /// The name could lead elsewhere, or is no name of a file.
    #[error(
        "`{0}` is no name for a recording: up to 64 letters, digits, `.`, `_` and `-`, the first \
         of which is a letter or a digit"
    )]
    Name(String),
    /// There is none of that name; others are there.
    #[error("no recording `{0}`")]
    Unknown(String, Vec<String>),
    /// The name is in use.
    #[error("there is a recording `{0}` already: choose another name, or remove it")]
    Taken(String),
    /// The directory may not hold more.
    #[error("the directory of recordings is full (recordings.{0}): remove one")]
    Full(String),
    /// Too many are under way.
    #[error("{0} are under way at once already: end one")]
    TooMany(usize),
    /// It is being made or replayed, or is not.
    #[error("{0} {1}")]
    UnderWay(String, &'static str),
    /// Nothing in it can be published here.
    #[error("nothing of {file} can be published here: {}", why.join("; "))]
    Nothing {
        /// The file.
        file: String,
        /// Why not, for each topic.
        why: Vec<String>,
    },
    /// The directory cannot be used.
    #[error(transparent)]
    Shelf(#[from] ShelfError),
    /// The file cannot be read as a recording.
    #[error("{0}: {1}")]
    Read(String, #[source] ReadError),
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its own words.
        source: std::io::Error,
    },
}
