//! Reads files of a machine below a root directory.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A machine, given by the root directory of its files.
#[derive(Debug)]
pub struct Machine {
    root: PathBuf,
}

impl Machine {
    /// The machine whose files are below `root`.
    #[must_use]
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    pub(crate) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// The start of a file, at most this many bytes of it.
    pub(crate) fn start_of(&self, path: &str, most: u64) -> Option<String> {
        let mut start = Vec::new();
        File::open(self.path(path)).ok()?.take(most).read_to_end(&mut start).ok()?;
        Some(String::from_utf8_lossy(&start).into_owned())
    }

    /// Names of the files in a directory.
    pub(crate) fn names(&self, path: &str) -> impl Iterator<Item = String> {
        let entries = std::fs::read_dir(self.path(path)).into_iter().flatten().flatten();
        entries.filter_map(|entry| entry.file_name().into_string().ok())
    }

    pub(crate) fn text(&self, path: &str) -> Option<String> {
        Some(std::fs::read_to_string(self.path(path)).ok()?.trim().to_owned())
    }
}
