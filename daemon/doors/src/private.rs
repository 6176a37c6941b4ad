//! Reads files with secrets, only if nobody else can.

use std::fs::File;
use std::io::{self, Read as _};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// Others can read the file.
#[derive(Debug, thiserror::Error)]
#[error("others may read {}, which holds a secret: `chmod 600 {}`", .0.display(), .0.display())]
pub struct NotPrivate(PathBuf);

/// Why a secret was not read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PrivateError {
    #[error(transparent)]
    Read(#[from] io::Error),
    #[error(transparent)]
    Open(#[from] NotPrivate),
}

/// Reads a file that only its owner may read.
pub(crate) fn read(path: &Path) -> Result<String, PrivateError> {
    // Checked on the open file, which is the one read, even if its name is changed meanwhile.
    let mut file = File::open(path)?;
    if file.metadata()?.mode() & 0o077 != 0 {
        return Err(NotPrivate(path.to_owned()).into());
    }
    let mut text = String::new();
    file.read_to_string(&mut text)?;
    Ok(text)
}
