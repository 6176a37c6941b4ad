//! Why a recording cannot be read.

use mcap::McapError;

/// The file cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReadError {
    #[error(transparent)]
    Io(#[from] std::io::Error),
    #[error("it is no MCAP file")]
    NotMcap,
    #[error("it is a damaged MCAP file: {0}")]
    Mcap(#[from] McapError),
    #[error(
        "it has no index, and its chunks are compressed ({0}): `mcap recover` reads such files"
    )]
    Compressed(String),
    #[error("it is damaged: something in it is said to be larger than the file")]
    Beyond,
    #[error("it is damaged: a sample is dated years after the one before it")]
    Dates,
}
