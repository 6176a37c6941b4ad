//! A file of a project that is to be written.

use std::fs;
use std::io::{self, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

/// A file of a project.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Where it belongs, below the project's directory.
    pub path: PathBuf,
    /// What it contains.
    pub text: String,
    /// Whether it is a program.
    pub executable: bool,
}

/// What became of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// It was not there, and is now.
    Created,
    /// It had other contents, which were replaced.
    Replaced,
    /// It has these contents already.
    Same,
    /// It has other contents, which were left.
    Kept,
}

impl File {
    /// A file with these contents.
    #[must_use]
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), text: text.into(), executable: false }
    }

    /// A program with these contents.
    #[must_use]
    pub fn program(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { executable: true, ..Self::new(path, text) }
    }

    /// Writes it below `directory`. An existing file with other contents is left unless `replace`.
    ///
    /// # Errors
    /// A directory or the file cannot be made, or what is there cannot be read. The error names the
    /// file.
    pub fn write(&self, directory: &Path, replace: bool) -> io::Result<Written> {
        let path = directory.join(&self.path);
        let named =
            |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        let before = match fs::read(&path) {
            Ok(bytes) => Some(bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(named(error)),
        };
        if before.as_deref() == Some(self.text.as_bytes()) {
            return Ok(Written::Same);
        }
        if before.is_some() && !replace {
            return Ok(Written::Kept);
        }
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(named)?;
        }
        let mode = if self.executable { 0o777 } else { 0o666 };
        let mut options = fs::OpenOptions::new();
        // A file that appears meanwhile is somebody else's.
        options.write(true).mode(mode).create_new(before.is_none()).truncate(before.is_some());
        let mut file = options.open(&path).map_err(named)?;
        file.write_all(self.text.as_bytes()).map_err(named)?;
        Ok(if before.is_some() { Written::Replaced } else { Written::Created })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_user_wrote_is_left_unless_replacing_is_asked_for() {
        let scratch = tempfile::tempdir().unwrap();
        let file = File::new("codels/a.c", "new\n");
        assert_eq!(file.write(scratch.path(), false).unwrap(), Written::Created);
        assert_eq!(file.write(scratch.path(), false).unwrap(), Written::Same);
        fs::write(scratch.path().join("codels/a.c"), "mine\n").unwrap();
        assert_eq!(file.write(scratch.path(), false).unwrap(), Written::Kept);
        assert_eq!(fs::read_to_string(scratch.path().join("codels/a.c")).unwrap(), "mine\n");
        assert_eq!(file.write(scratch.path(), true).unwrap(), Written::Replaced);
    }

    #[test]
    fn an_error_names_the_file() {
        let scratch = tempfile::tempdir().unwrap();
        fs::write(scratch.path().join("codels"), "a file").unwrap();
        let told = File::new("codels/a.c", "").write(scratch.path(), false).unwrap_err();
        assert!(told.to_string().contains("codels/a.c: "), "{told}");
    }
}
