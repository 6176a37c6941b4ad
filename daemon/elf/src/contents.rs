//! The bytes of a library file, read once: the description is read, and the library loaded, from
//! them.

use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use crate::error::OpenError;
use crate::languages;
use crate::read::{self, EmbeddedDescription};

/// The content of a library file for this machine. No code of it runs yet.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The file.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Identifies contents: a SHA-256.
pub type Digest = [u8; 32];

/// Whether the codels in this file are a script: text that an interpreter runs.
#[must_use]
pub fn is_script(path: &Path) -> bool {
    languages::of(path).is_some()
}

impl Contents {
    /// Reads the file at `path`: a shared object, or a script, which is not looked at here.
    ///
    /// # Errors
    /// The file is missing, truncated or damaged, or no shared object for this machine.
    pub fn read(path: &Path) -> Result<Self, OpenError> {
        let bytes = read::read(path)?;
        if !is_script(path) {
            read::check(path, &bytes)?;
        }
        Ok(Self { path: path.to_owned(), bytes })
    }

    /// Whether this is a script.
    #[must_use]
    pub fn is_script(&self) -> bool {
        is_script(&self.path)
    }

    /// The description embedded in the symbol `genom_description`.
    ///
    /// # Errors
    /// The symbol exists but is not text.
    pub fn description(&self) -> Result<Option<EmbeddedDescription>, OpenError> {
        read::description_of(&self.path, &self.bytes)
    }

    /// A hash of the content, independent of the file's name and date.
    #[must_use]
    pub fn digest(&self) -> Digest {
        Sha256::digest(&self.bytes).into()
    }
}
