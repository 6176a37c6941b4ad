//! Errors of exchanging the library of a running component.

use genom_host::CannotExchange;
use genom_runtime::NoRest;

use crate::known::ReadError;
use crate::loading::LoadError;

/// Why the library of a component was not exchanged. It goes on as before.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ReloadError {
    /// No component of that name runs.
    #[error("{0} does not run: it is being loaded or unloaded")]
    NotThere(String),
    /// Another exchange is under way.
    #[error("the library of {0} is just being exchanged: ask again in a moment")]
    Busy(String),
    /// The new library cannot be found, read or opened, or does not fit its description.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// It is a library of another component.
    #[error(
        "{name} is a component {runs}, and the library is one of {found}: load it with `genomctl \
         load`"
    )]
    OtherComponent { name: String, runs: String, found: String },
    /// The description changed.
    #[error("the description of {name} changed: unload it, and load it again")]
    Description { name: String },
    /// What a native type of the IDS points to is known to codels only.
    #[error(
        "{name} has native data ({native}), which only its library knows: unload it, and load it \
         again"
    )]
    Native { name: String, native: String },
    /// There was no moment at which no codel ran and all activities were at a pause.
    #[error(transparent)]
    NoRest(#[from] NoRest),
    /// The two do not have the same memory.
    #[error(transparent)]
    Exchange(#[from] CannotExchange),
}

impl From<ReadError> for ReloadError {
    fn from(error: ReadError) -> Self {
        Self::Load(error.into())
    }
}
