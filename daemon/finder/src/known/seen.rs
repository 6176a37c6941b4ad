//! Records what was read from disk for a description, to tell later whether reading it again would
//! give the same result.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use genom_description::source::{Disk, Files, tidy};

/// Files that record what was read.
pub(super) struct Witness<'a> {
    files: &'a dyn Files,
    /// Name of an embedded text: whatever the disk holds under this name is ignored.
    text: Option<PathBuf>,
    seen: RefCell<Seen>,
}

/// Answers of the file system, by path.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Whether there is a file.
    there: BTreeMap<PathBuf, bool>,
    /// Its contents; `None` if it could not be read.
    contents: BTreeMap<PathBuf, Option<Vec<u8>>>,
}

impl Seen {
    /// Reads through `files` and records everything but `text`.
    pub(super) fn through<'a>(files: &'a dyn Files, text: Option<&Path>) -> Witness<'a> {
        Witness { files, text: text.map(tidy), seen: RefCell::default() }
    }

    /// The contents of the files that were read.
    pub(super) fn contents(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let read = |(path, text): (&PathBuf, &Option<Vec<u8>>)| Some((path.clone(), text.clone()?));
        self.contents.iter().filter_map(read).collect()
    }

    /// Whether the file system gives the same answers now.
    pub(super) fn is_current(&self) -> bool {
        let same = |(path, before): (&PathBuf, &Option<Vec<u8>>)| Disk.read(path).ok() == *before;
        self.there.iter().all(|(path, before)| Disk.is_file(path) == *before)
            && self.contents.iter().all(same)
    }
}

impl Witness<'_> {
    /// What was recorded.
    pub(super) fn finish(self) -> Seen {
        self.seen.into_inner()
    }

    fn note(&self, path: &Path, note: impl FnOnce(&mut Seen, PathBuf)) {
        if self.text.as_deref() != Some(&tidy(path)) {
            note(&mut self.seen.borrow_mut(), path.to_owned());
        }
    }
}

impl Files for Witness<'_> {
    fn is_file(&self, path: &Path) -> bool {
        let there = self.files.is_file(path);
        self.note(path, |seen, path| _ = seen.there.insert(path, there));
        there
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let read = self.files.read(path);
        self.note(path, |seen, path| _ = seen.contents.insert(path, read.as_ref().ok().cloned()));
        read
    }

    fn identity(&self, path: &Path) -> PathBuf {
        self.files.identity(path)
    }
}
