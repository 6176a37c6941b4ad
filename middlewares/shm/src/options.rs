//! What can be chosen when the middleware is opened.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde::Deserialize;

use crate::error::ShmError;

/// `[backends.shm]`; `configs/shm.toml` explains it.
///
/// Peers meet when prefix and root are the same. Left out, they are those of iceoryx2's
/// configuration file, or, where it says nothing, this user's own
/// ([`default_prefix`](crate::default_prefix), [`default_root`](crate::default_root)).
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Start of the names of all files and shared memory.
    pub prefix: Option<String>,
    /// Folder of the files that say what exists.
    pub root: Option<PathBuf>,
    /// Readers a port may have. The first who opens a port decides for all.
    pub readers: usize,
    /// Unread samples a reader may hold. The first who opens a port decides for all.
    pub depth: usize,
    /// Name of the node that others see. No key.
    #[serde(skip)]
    pub node: String,
    /// Bytes of shared memory that are left to others, and to small samples: no port is opened and
    /// no large sample written beyond, since the system ends who writes where nothing is left. No
    /// key.
    #[serde(skip)]
    pub keep_free: u64,
}

impl Options {
    /// Greatest number of readers, and of unread samples of one.
    pub const MOST: usize = 1024;

    /// Whether the numbers are such that iceoryx2 can make a port of them.
    pub(crate) fn check(&self) -> Result<(), ShmError> {
        let within = |key, value: usize, range: RangeInclusive<usize>| {
            let (least, most) = (*range.start(), *range.end());
            let fits = range.contains(&value);
            fits.then_some(()).ok_or(ShmError::Range { key, value, least, most })
        };
        within("readers", self.readers, 1..=Self::MOST)?;
        within("depth", self.depth, 2..=Self::MOST)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            prefix: None,
            root: None,
            readers: 12,
            depth: 16,
            node: "genomd".to_owned(),
            keep_free: 1 << 20,
        }
    }
}
