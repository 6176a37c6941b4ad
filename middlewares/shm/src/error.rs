//! Errors of opening the middleware, or anything on it.

use std::path::PathBuf;

use genom_middleware::{Address, OpenError};

use crate::limits;

/// Name of this middleware in configurations and errors.
pub(crate) const BACKEND: &str = "shm";

/// Opening the middleware failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShmError {
    /// A number is out of range.
    #[error("{key} = {value}: give {least} to {most}")]
    Range {
        /// Key of the configuration.
        key: &'static str,
        /// Its value.
        value: usize,
        /// Smallest valid value.
        least: usize,
        /// Greatest valid value.
        most: usize,
    },
    /// The prefix is not valid for iceoryx2.
    #[error("{0:?} is no legal start of file names: use letters, digits, `_` and `-`")]
    Prefix(String),
    /// The root is not a valid path for iceoryx2.
    #[error("{0} is no legal folder for iceoryx2: give a shorter absolute path")]
    Root(PathBuf),
    /// The name of the node is not valid for iceoryx2.
    #[error("{0:?} is no legal node name: give a shorter one")]
    Node(String),
    /// The folder of iceoryx2 could not be created.
    #[error("cannot make {path}: {why}; `root` in [backends.shm] names another folder")]
    Folder {
        /// Folder of iceoryx2's files.
        path: PathBuf,
        /// The system's message.
        why: String,
    },
    /// A file or folder belongs to another user, who could end or block this process by changing
    /// it.
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
        /// Number of the user that this process runs as.
        user: u32,
    },
    /// Other users may write into the folder of iceoryx2.
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
    /// The node could not be created.
    #[error("iceoryx2 cannot make a node in {root}: {why}; is the folder writable for this user?")]
    Create {
        /// Folder of iceoryx2's files.
        root: String,
        /// iceoryx2's message.
        why: String,
    },
}

/// An error for this address. If a limit of the system has been reached, the message names it.
pub(crate) fn failed(at: &Address, why: &str) -> OpenError {
    let why = limits::explained(why);
    OpenError::Failed { backend: BACKEND.to_owned(), address: at.clone(), why }
}
