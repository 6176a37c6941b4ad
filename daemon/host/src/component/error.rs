//! Why a library does not fit its description.

use std::fmt;
use std::path::PathBuf;

/// A component could not be loaded: everything that is wrong, at once.
#[derive(Debug)]
pub struct LoadErrors {
    /// File that was to be loaded, as it was asked for.
    pub library: PathBuf,
    /// What is wrong; never empty.
    pub errors: Vec<LoadError>,
}

impl fmt::Display for LoadErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let library = self.library.display();
        let lines = self.errors.iter().map(|error| format!("{library}: {error}"));
        f.write_str(&lines.collect::<Vec<_>>().join("\n"))
    }
}

impl std::error::Error for LoadErrors {}

/// One thing that is wrong. `place` is where the `.gen` says it: file and line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The library lacks a codel.
    #[error("codel `{codel}` ({place}) is not defined{hint}")]
    MissingCodel {
        /// Name of the C function.
        codel: String,
        /// Where it is declared.
        place: String,
        /// What looks like it, or empty.
        hint: String,
    },
    /// The component's language is none that the host calls.
    #[error(
        "component `{component}` ({place}) has lang \"{lang}\": codels are called by the C \
         interface (lang \"c\"; their sources may be C++ or Rust) or by that of C++ (lang \"c++\")"
    )]
    Language {
        /// Name of the component.
        component: String,
        /// Where it is declared.
        place: String,
        /// Its `lang`.
        lang: String,
    },
    /// The codels' C++ library is not that of the host.
    #[error(
        "component `{component}` is linked with libc++, this daemon with libstdc++: texts and \
         sequences would not fit (leave -stdlib=libc++ away, or give the codels the C interface)"
    )]
    OtherLibrary {
        /// Name of the component.
        component: String,
    },
    /// A type has no place in memory.
    #[error("{what} ({place}): {why}")]
    Type {
        /// What has that type.
        what: String,
        /// Where it is declared.
        place: String,
        /// Why it cannot be laid out.
        why: String,
    },
    /// An argument leads nowhere.
    #[error("argument `{parameter}` of codel `{codel}` ({place}): {why}")]
    Argument {
        /// Name of the C function.
        codel: String,
        /// Name of the argument.
        parameter: String,
        /// Where it is declared.
        place: String,
        /// Why it has no address.
        why: String,
    },
    /// The library says something else of a codel or type than the description.
    #[error("{0}")]
    Contract(crate::contract::Difference),
    /// The machine gives no memory for the functions of ports and remotes.
    #[error("no memory for the C functions of ports and remotes")]
    NoClosures,
}
