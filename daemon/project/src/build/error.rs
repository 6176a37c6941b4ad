//! Why a component was not built.

use std::io;
use std::path::PathBuf;

/// Why a component was not built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// Nothing here can be built.
    #[error("{}: no .gen file with codels, and no build files", .0.display())]
    Nothing(PathBuf),
    /// Several descriptions, and no build files that say which.
    #[error("{}: several .gen files with a component: {}", directory.display(), names.join(", "))]
    Several {
        /// The directory.
        directory: PathBuf,
        /// The files.
        names: Vec<String>,
    },
    /// A description without codels beside it.
    #[error("{}: no codels: there is no .c, .cc, .cpp or .cxx file in {}", description.display(), tried.display())]
    NoCodels {
        /// The description.
        description: PathBuf,
        /// Where sources were looked for.
        tried: PathBuf,
    },
    /// The header cannot be written.
    #[error(transparent)]
    Header(#[from] genom_description_tools::HeaderError),
    /// The description declares no component.
    #[error("{}: declares no component", .0.display())]
    NoComponent(PathBuf),
    /// pkg-config does not know a package, or cannot be run.
    #[error("{0}")]
    Package(String),
    /// A compiler cannot be run.
    #[error("{program}: {source}; install it, or set {variable}")]
    Program {
        /// Its name.
        program: String,
        /// The environment variable that selects another.
        variable: &'static str,
        /// Why.
        source: io::Error,
    },
    /// A compiler found mistakes, which were told.
    #[error("{failed} of {all} sources do not compile")]
    Refused {
        /// Sources with mistakes.
        failed: usize,
        /// Sources in all.
        all: usize,
    },
    /// The linker refused.
    #[error("the library was not linked")]
    Unlinked,
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl BuildError {
    /// For `map_err`: an error of this file.
    pub(super) fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
