//! What a sandboxed process may use besides what its configuration grants.

use std::path::PathBuf;

/// What the process itself needs, besides what its configuration grants.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grants {
    /// Directories and files that it reads, such as libraries.
    pub read: Vec<PathBuf>,
    /// Those that it reads and writes. Directories that are missing are made.
    pub write: Vec<PathBuf>,
    /// Directories with Unix sockets that it may send to.
    pub reach: Vec<PathBuf>,
}
