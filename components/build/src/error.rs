//! Why a component could not be built.

use std::io;
use std::path::{Path, PathBuf};

/// Why a component could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// Nothing in the repository has that name.
    #[error("no component is called `{name}`; there are {known}")]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// Those that exist.
        known: String,
    },
    /// A folder or a file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which one.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A compiler or cargo is not installed.
    #[error("cannot run `{program}`: {source}; install it, or name another in ${variable}")]
    Program {
        /// The command.
        program: String,
        /// Environment variable that names another.
        variable: &'static str,
        /// Why it did not run.
        source: io::Error,
    },
    /// A compiler or cargo refused.
    #[error("`{command}` failed:\n{output}")]
    Refused {
        /// The whole command.
        command: String,
        /// What it printed on standard error.
        output: String,
    },
    /// Cargo built the package and named no such file.
    #[error("cargo built no {what} for package `{package}`")]
    NoArtifact {
        /// The package.
        package: String,
        /// Kind of file that was expected.
        what: &'static str,
    },
    /// Cargo does not tell where the workspace is.
    #[error("cargo does not describe the workspace")]
    Workspace(#[from] cargo_metadata::Error),
}

impl BuildError {
    /// Says which file an error is about.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { path, source }
    }
}
