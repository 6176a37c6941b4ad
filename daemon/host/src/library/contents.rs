//! The bytes of a library file, read once: what it carries is told, and it is loaded, from them.

use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use super::elf::{self, EmbeddedDescription};
use super::error::OpenError;

/// The contents of a file that is a library of this machine. Nothing of it runs yet.
#[derive(Debug)]
pub struct Contents {
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
}

/// What tells contents from others: a SHA-256.
pub type Digest = [u8; 32];

impl Contents {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// When the file is missing, truncated or damaged, or no shared object of this machine.
    pub fn read(path: &Path) -> Result<Self, OpenError> {
        let bytes = elf::read(path)?;
        elf::check(path, &bytes)?;
        Ok(Self { path: path.to_owned(), bytes })
    }

    /// The description that it carries in the symbol `genom_description`.
    ///
    /// # Errors
    /// When the symbol is there but holds no text.
    pub fn description(&self) -> Result<Option<EmbeddedDescription>, OpenError> {
        elf::description_of(&self.path, &self.bytes)
    }

    /// The same for the same contents only, whatever the file is called and whenever it was built.
    #[must_use]
    pub fn digest(&self) -> Digest {
        Sha256::digest(&self.bytes).into()
    }
}
