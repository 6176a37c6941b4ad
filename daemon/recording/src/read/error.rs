//! Why a recording cannot be read.

use mcap::McapError;

/// The file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The system refuses to read it.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It does not begin as one.
    #[error("it is no MCAP file")]
    NotMcap,
    /// Its content is not as the format says.
    #[error("it is a damaged MCAP file: {0}")]
    Mcap(#[from] McapError),
    /// Its records cannot be found without decompressing them.
    #[error(
        "it has no index, and its chunks are compressed ({0}): `mcap recover` reads such files"
    )]
    Compressed(String),
    /// It says of a part of it that it is longer than the file.
    #[error("it is damaged: something in it is said to be larger than the file")]
    Beyond,
    /// The dates of its samples cannot be true.
    #[error("it is damaged: a sample is dated years after the one before it")]
    Dates,
}
