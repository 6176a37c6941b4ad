//! Why a library does not fit its description.

use std::fmt;
use std::path::PathBuf;

/// A component could not be loaded: all errors together.
#[derive(Debug)]
pub struct LoadErrors {
    /// The file, by the path it was requested with.
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

/// A single error. `place` is the position in the `.gen`: file and line.
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
        /// A similar function, or empty.
        hint: String,
    },
    /// The host cannot call codels in the component's language.
    #[error(
        "component `{component}` ({place}) has lang \"{lang}\": codels are called by the C \
         interface (lang \"c\"; their sources may be C++ or Rust), by that of C++ (lang \"c++\"), or are \
         functions of a script ({scripts})"
    )]
    Language {
        /// Name of the component.
        component: String,
        /// Where it is declared.
        place: String,
        /// Its `lang`.
        lang: String,
        /// Those of scripts.
        scripts: String,
    },
    /// The process cannot load scripts of this language.
    #[error(
        "codels in {language} run in a cell that begins with them, and this process is none: give \
         the component a cell of its own, or take those of other components out of it first"
    )]
    NoInterpreter {
        /// As in `lang`.
        language: &'static str,
    },
    /// The script does not fit the description.
    #[error("{0}")]
    Codels(String),
    /// The codels are linked with another C++ library than the host.
    #[error(
        "component `{component}` is linked with libc++, this daemon with libstdc++: texts and \
         sequences would not fit (leave -stdlib=libc++ away, or give the codels the C interface)"
    )]
    OtherLibrary {
        /// Name of the component.
        component: String,
    },
    /// A type has no layout.
    #[error("{what} ({place}): {why}")]
    Type {
        /// The item with that type.
        what: String,
        /// Where it is declared.
        place: String,
        /// The reason.
        why: String,
    },
    /// An argument has no address.
    #[error("argument `{parameter}` of codel `{codel}` ({place}): {why}")]
    Argument {
        /// Name of the C function.
        codel: String,
        /// Name of the argument.
        parameter: String,
        /// Where it is declared.
        place: String,
        /// The reason.
        why: String,
    },
    /// The library has another definition of a codel or type than the description.
    #[error("{0}")]
    Contract(crate::contract::Difference),
    /// The system provides no memory for the functions of ports and remotes.
    #[error("no memory for the C functions of ports and remotes")]
    NoClosures,
}

/// The code of two components cannot be exchanged. Nothing was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CannotExchange {
    /// The component that runs does not rest.
    #[error("another component rests")]
    NotAtRest,
    /// Their descriptions differ.
    #[error("the descriptions of the two differ")]
    Unlike,
}
