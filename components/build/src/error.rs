//! Errors of building a component.

use std::io;
use std::path::{Path, PathBuf};

/// Why a component could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// There is no component of that name.
    #[error("no component is called `{name}`; there are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A folder or a file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// Its path.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// A compiler or cargo is not installed.
    #[error("cannot run `{program}`: {source}; install it, or name another in ${variable}")]
    Program {
        /// The command.
        program: String,
        /// The environment variable that selects another command.
        variable: &'static str,
        /// The error of the system.
        source: io::Error,
    },
    /// A compiler or cargo failed.
    #[error("`{command}` failed:\n{output}")]
    Refused {
        /// The whole command.
        command: String,
        /// Its standard error.
        output: String,
    },
    /// Cargo built the package, but did not report such a file.
    #[error("cargo built no {what} for package `{package}`")]
    NoArtifact {
        /// The package.
        package: String,
        /// Kind of file that was expected.
        what: &'static str,
    },
    /// Cargo does not report where the workspace is.
    #[error("cargo does not describe the workspace")]
    Workspace(#[from] cargo_metadata::Error),
}

impl BuildError {
    /// Adds the path to an error of the system.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}
