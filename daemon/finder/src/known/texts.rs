//! The texts that a description was read from, for a component that is to go on with it when its
//! files hold another one.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use genom_description::source::{Memory, tidy};
use serde::{Deserialize, Serialize};

/// The texts of one description.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Texts {
    /// The path of the description, or its name if it is embedded in a library.
    pub(super) name: PathBuf,
    pub(super) embedded: bool,
    /// Its text and those that it includes, by the paths by which they were read.
    pub(super) texts: BTreeMap<PathBuf, Vec<u8>>,
}

impl Texts {
    /// Its name in messages.
    pub(super) fn name(&self) -> &Path {
        &self.name
    }

    /// Its file, whatever that holds now, unless it is embedded in a library.
    pub(super) fn file(&self) -> Option<PathBuf> {
        (!self.embedded).then(|| self.name.clone())
    }

    /// All of them, by the paths by which they were read.
    pub fn all(self) -> impl Iterator<Item = (PathBuf, Vec<u8>)> {
        self.texts.into_iter()
    }

    /// Files that hold nothing else.
    pub(super) fn files(&self) -> Memory {
        let mut files = Memory::new();
        for (path, text) in &self.texts {
            // Other spellings of a path lead there, too.
            files.insert(tidy(path), text.as_slice());
            files.insert(path, text.as_slice());
        }
        files
    }

    /// Writes them to a file.
    ///
    /// # Errors
    /// The system refuses, or a path is no text.
    pub fn write(&self, to: &Path) -> io::Result<()> {
        fs::write(to, serde_json::to_vec(self)?)
    }

    /// Reads them from a file; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(from: &Path) -> io::Result<Option<Self>> {
        match fs::read(from) {
            Ok(text) => Ok(Some(serde_json::from_slice(&text)?)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }
}
