//! Reading files: from the disk, or from memory for editors and tests.

use std::collections::BTreeMap;
use std::fs::{self, File, FileType};
use std::io::{self, Read as _};
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

/// Source of the text of files.
pub trait Files {
    /// Whether `path` names something that [`Files::read`] may read.
    fn is_file(&self, path: &Path) -> bool;

    /// The whole content of a file.
    ///
    /// # Errors
    /// The error of the system when the file is missing, a directory or unreadable.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// A canonical path, equal for all paths to the same file; `path` itself when there is none.
    fn identity(&self, path: &Path) -> PathBuf {
        path.to_owned()
    }
}

/// Bytes of the largest file that is read: far more than any real description.
pub(crate) const LARGEST: usize = 1 << 24;

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn is_file(&self, path: &Path) -> bool {
        path.is_file()
    }

    /// Refuses what is no regular file, since it may have no end, and files larger than 16 MiB.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        check_file(path)?;
        let mut bytes = Vec::new();
        // Reading one byte more than the limit shows that the file is too large.
        File::open(path)?.take(LARGEST as u64 + 1).read_to_end(&mut bytes)?;
        if bytes.len() > LARGEST {
            let message = format!("it is larger than {} MiB", LARGEST >> 20);
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
        }
        Ok(bytes)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        path.canonicalize().unwrap_or_else(|_| path.to_owned())
    }
}

/// Checks that a path leads to a regular file.
///
/// # Errors
/// The error of the system, or what is there instead: a directory, a FIFO, a socket, a device.
pub fn check_file(path: &Path) -> io::Result<()> {
    match no_file(fs::metadata(path)?.file_type()) {
        None => Ok(()),
        Some(what) => {
            Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}, not a file")))
        }
    }
}

/// What something is that is not a regular file; `None` for one that is.
fn no_file(kind: FileType) -> Option<&'static str> {
    if kind.is_file() {
        None
    } else if kind.is_dir() {
        Some("a directory")
    } else if kind.is_fifo() {
        Some("a FIFO")
    } else if kind.is_socket() {
        Some("a socket")
    } else {
        Some("a device")
    }
}

/// Texts in memory, with or without the disk behind them.
///
/// An editor puts its unsaved buffers here; a test puts all its files here.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    texts: BTreeMap<PathBuf, Vec<u8>>,
    disk: bool,
}

impl Memory {
    /// Without any file, and without the disk.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The files of the disk; [`Memory::insert`] hides some.
    #[must_use]
    pub fn over_disk() -> Self {
        Self { texts: BTreeMap::new(), disk: true }
    }

    /// Puts a text in place of a file.
    pub fn insert(&mut self, path: impl Into<PathBuf>, text: impl Into<Vec<u8>>) {
        self.texts.insert(path.into(), text.into());
    }

    /// Removes a text; the file on the disk is visible again.
    pub fn remove(&mut self, path: &Path) {
        self.texts.remove(path);
    }

    /// `a/./b/../c` and `a/c` are one file: in memory there are no symbolic links.
    fn find(&self, path: &Path) -> Option<&Vec<u8>> {
        self.texts.get(path).or_else(|| self.texts.get(&tidy(path)))
    }
}

impl Files for Memory {
    fn is_file(&self, path: &Path) -> bool {
        self.find(path).is_some() || (self.disk && Disk.is_file(path))
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        match self.find(path) {
            Some(text) => Ok(text.clone()),
            None if self.disk => Disk.read(path),
            None => Err(io::Error::from(io::ErrorKind::NotFound)),
        }
    }

    fn identity(&self, path: &Path) -> PathBuf {
        if self.disk { Disk.identity(path) } else { tidy(path) }
    }
}

/// The path without `.` and `..`, so that different spellings of a path are equal.
#[must_use]
pub fn tidy(path: &Path) -> PathBuf {
    use std::path::Component;
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_hides_the_disk_and_knows_roundabout_names() {
        let mut files = Memory::new();
        files.insert("d/a.gen", "x");
        assert!(files.is_file(Path::new("d/./e/../a.gen")));
        assert!(!files.is_file(Path::new("Cargo.toml")));
        assert!(Memory::over_disk().is_file(Path::new("Cargo.toml")));
    }
}
