//! Errors of exchanging the library of a running component.

use std::path::PathBuf;

use genom_host::CannotExchange;
use genom_runtime::NoRest;
use genom_types::native::NotConverted;

use crate::components::FreezeError;
use crate::components::UnloadError;
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
    /// Loading it ends a process.
    #[error("{} ends the process that loads it ({end}): nothing was changed", library.display())]
    Crashes { library: PathBuf, end: String },
    /// It is a library of another component.
    #[error(
        "{name} is a component {runs}, and the library is one of {found}: load it with `genomctl \
         load`"
    )]
    OtherComponent { name: String, runs: String, found: String },
    /// A port that is connected is gone, or another one.
    #[error(
        "port {name}/{port} is connected ({peer}), and the new description has {found}: disconnect it first"
    )]
    Port { name: String, port: String, peer: String, found: &'static str },
    /// Native data was refused.
    #[error("{name} goes on as it is: {source}")]
    NotConverted { name: String, source: NotConverted },
    /// Its state cannot be taken.
    #[error(transparent)]
    Freeze(#[from] FreezeError),
    /// It does not stop.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// The new one did not start; the one before runs again.
    #[error("{why}; it runs again as it was before")]
    RolledBack { why: LoadError },
    /// Neither did the one before.
    #[error("{why}; and {name} does not run any more: {again}")]
    Lost { name: String, why: Box<LoadError>, again: Box<LoadError> },
    /// There was no moment at which no codel ran and all activities were at a pause.
    #[error(transparent)]
    NoRest(#[from] NoRest),
    /// The two do not have the same memory.
    #[error(transparent)]
    Exchange(#[from] CannotExchange),
}
