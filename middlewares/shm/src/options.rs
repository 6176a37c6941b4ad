//! What can be chosen when the middleware is opened.

use std::path::PathBuf;

/// Options of [`Shm::open`](crate::Shm::open).
///
/// Peers meet when prefix and root are the same. Left out, they are those of iceoryx2's
/// configuration file, or, where it says nothing, this user's own
/// ([`default_prefix`](crate::default_prefix), [`default_root`](crate::default_root)).
#[derive(Clone, Debug)]
pub struct Options {
    /// Name of the node that others see.
    pub node: String,
    /// Start of the names of all files and shared memory.
    pub prefix: Option<String>,
    /// Folder of the files that say what exists.
    pub root: Option<PathBuf>,
    /// Unread samples a reader may hold. The first who opens a port decides for all.
    pub depth: usize,
    /// Readers a port may have. The first who opens a port decides for all.
    pub readers: usize,
    /// Bytes of shared memory that are left to others, and to small samples: no port is opened and
    /// no large sample written beyond, since the system ends who writes where nothing is left.
    pub keep_free: u64,
}

impl Options {
    /// Greatest number of readers, and of unread samples of one.
    pub const MOST: usize = 1024;
}

impl Default for Options {
    fn default() -> Self {
        Self {
            node: "genomd".to_owned(),
            prefix: None,
            root: None,
            depth: 16,
            readers: 12,
            keep_free: 1 << 20,
        }
    }
}
