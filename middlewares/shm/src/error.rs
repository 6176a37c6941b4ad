//! Why the middleware, or something on it, could not be opened.

use std::path::PathBuf;

use genom_middleware::{Address, OpenError};

use crate::limits;

/// What errors call this middleware.
pub(crate) const BACKEND: &str = "shm";

/// Opening the middleware failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShmError {
    /// A name that iceoryx2 cannot use.
    #[error("{0:?} is no legal start of file names: use letters, digits, `_` and `-`")]
    Prefix(String),
    /// A path that iceoryx2 cannot use.
    #[error("{0} is no legal folder for iceoryx2: give a shorter absolute path")]
    Root(PathBuf),
    /// A name that iceoryx2 cannot use.
    #[error("{0:?} is no legal node name: give a shorter one")]
    Node(String),
    /// The node could not be made.
    #[error("iceoryx2 cannot make a node in {root}: {why}; is the folder writable for this user?")]
    Create {
        /// Folder of iceoryx2's files.
        root: String,
        /// iceoryx2's own words.
        why: String,
    },
}

/// An address was refused; a limit of the system that is reached is named.
pub(crate) fn failed(at: &Address, why: &str) -> OpenError {
    let why = limits::explained(why);
    OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why }
}
