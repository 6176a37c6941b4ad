//! Why nothing was added.

use std::io;
use std::path::PathBuf;

use genom_description::Analysis;

/// Why nothing was added. Nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum AddError {
    /// The description has mistakes as it is.
    #[error("the description has mistakes as it is: correct them first")]
    Mistakes(Box<Analysis>),
    /// It would have some with the addition; their places are those in the text with it.
    #[error("the description would have mistakes")]
    Refused(Box<Analysis>),
    /// The description declares no component.
    #[error("{}: declares no component", .0.display())]
    NoComponent(PathBuf),
    /// The component is declared in another file, or by a macro.
    #[error("{}: the braces of its component are in another file; name that file", .0.display())]
    Elsewhere(PathBuf),
    /// The file is not UTF-8, or begins with a byte order mark.
    #[error("{}: is not plain UTF-8; convert it first", .0.display())]
    Encoding(PathBuf),
    /// A word that is to be part of the description has characters that it cannot have.
    #[error("`{word}` is no {what}")]
    Word {
        /// What it was given as.
        what: &'static str,
        /// The word.
        word: String,
    },
    /// A parameter of a function or an activity has no type.
    #[error("`{0}` has no type; write {0}=double, or {0}=double=1.0 with a default")]
    NoType(String),
    /// A parameter of an attribute has a type.
    #[error(
        "`{0}` is a parameter of an attribute, whose type is that of the member of the ids; write it without type"
    )]
    Typed(String),
    /// No task was named for an activity, and there is not exactly one.
    #[error("name the task that runs it; {0}")]
    WhichTask(String),
    /// The sources have no place for a codel.
    #[error("{}: {why}", path.display())]
    Sources {
        /// The file.
        path: PathBuf,
        /// What it lacks.
        why: String,
    },
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl AddError {
    /// For `map_err`: an error of this file.
    pub(super) fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
