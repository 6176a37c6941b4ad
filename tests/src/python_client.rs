//! Runs the Python client's own tests, `clients/python/tests`.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Finished, repository};

/// The interpreter of the machine.
#[must_use]
pub fn python() -> PathBuf {
    std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()).into()
}

/// A run of one file of them, without the environment of this process.
#[must_use]
pub fn client_tests(interpreter: &Path, options: &[&str], file: &str) -> Command {
    let package = repository().join("clients/python");
    let mut command = Command::new(interpreter);
    command
        .current_dir(&package)
        .env_clear()
        .env("PATH", std::env::var_os("PATH").unwrap_or_default())
        .env("PYTHONPATH", package.join("src"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        // An unclosed socket or a forgotten thread is an error, too.
        .args(["-W", "error"])
        .args(options)
        .args(["-m", "unittest", "--verbose", file]);
    command
}

impl Finished {
    /// The tests of that run passed; no file may contain no tests, or skip some.
    #[track_caller]
    pub fn expect_client_passed(&self) {
        self.expect_code(0);
        assert!(!self.err.contains("Ran 0 tests"), "{}", self.err);
        assert!(!self.err.contains("skipped"), "{}", self.err);
    }
}
