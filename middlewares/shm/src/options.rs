//! Options for opening the middleware.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use serde::Deserialize;

use crate::error::ShmError;

/// Section `[backends.shm]` of the configuration; `configs/shm.toml` explains it.
///
/// Programs with the same prefix and root see each other. The defaults are those of iceoryx2's
/// configuration file or, if it sets none, folders and names of this user
/// ([`default_prefix`](crate::default_prefix), [`default_root`](crate::default_root)).
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Prefix of the names of all files and shared memory segments.
    pub prefix: Option<String>,
    /// Folder of iceoryx2's files that describe nodes and services.
    pub root: Option<PathBuf>,
    /// Greatest number of readers of a port. Whoever opens a port first decides for all.
    pub readers: usize,
    /// Greatest number of unread samples per reader. Whoever opens a port first decides for all.
    pub depth: usize,
    /// Name of the node, visible to others. Not a key of the configuration.
    #[serde(skip)]
    pub node: String,
    /// Bytes of shared memory that must stay free for other programs and for small samples. Below
    /// that, opening a port and writing a large sample are refused, because Linux kills (SIGBUS) a
    /// process that writes where no memory is left. Not a key of the configuration.
    #[serde(skip)]
    pub keep_free: u64,
}

impl Options {
    /// Greatest valid number of readers, and of unread samples per reader.
    pub const MOST: usize = 1024;

    /// Checks that iceoryx2 can create ports with these numbers.
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
