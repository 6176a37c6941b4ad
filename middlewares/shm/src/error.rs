//! Why the middleware, or something on it, could not be opened.

use std::path::PathBuf;

use genom_middleware::{Address, OpenError};

use crate::limits;

/// What configurations and errors call this middleware.
pub(crate) const BACKEND: &str = "shm";

/// Opening the middleware failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShmError {
    /// A number out of range.
    #[error("{key} = {value}: give {least} to {most}")]
    Range {
        /// Key of the configuration.
        key: &'static str,
        /// What it is set to.
        value: usize,
        /// The least that it may be.
        least: usize,
        /// And the most.
        most: usize,
    },
    /// A name that iceoryx2 cannot use.
    #[error("{0:?} is no legal start of file names: use letters, digits, `_` and `-`")]
    Prefix(String),
    /// A path that iceoryx2 cannot use.
    #[error("{0} is no legal folder for iceoryx2: give a shorter absolute path")]
    Root(PathBuf),
    /// A name that iceoryx2 cannot use.
    #[error("{0:?} is no legal node name: give a shorter one")]
    Node(String),
    /// The folder of iceoryx2 could not be made.
    #[error("cannot make {path}: {why}; `root` in [backends.shm] names another folder")]
    Folder {
        /// Folder of iceoryx2's files.
        path: PathBuf,
        /// The system's own words.
        why: String,
    },
    /// Something belongs to another user, who could end or hang this process by it.
    #[error(
        "{path} belongs to user {owner} (mode {mode:o}), not to user {user} as whom this runs: have \
         it removed, or set `root` and `prefix` in [backends.shm] to some of your own"
    )]
    Foreign {
        /// The file or folder.
        path: PathBuf,
        /// User number of the owner.
        owner: u32,
        /// Mode bits, as `chmod` takes them.
        mode: u32,
        /// Who this process runs as.
        user: u32,
    },
    /// Others may change the folder of iceoryx2.
    #[error(
        "others may change {path} (mode {mode:o}), and so end or hang whoever uses it: `chmod go-w \
         {path}`, or set `root` in [backends.shm] to another folder"
    )]
    Open {
        /// Folder of iceoryx2's files.
        path: PathBuf,
        /// Mode bits, as `chmod` takes them.
        mode: u32,
    },
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
