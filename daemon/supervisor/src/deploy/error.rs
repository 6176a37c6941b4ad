//! Why a step of a deployment was not taken, or could not be taken back.

use std::time::Duration;

use crate::components::UnloadError;
use crate::components::request::RequestError;
use crate::connections::{BindError, ConnectError};
use crate::loading::LoadError;

/// A step of a deployment was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// A component does not load.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A component does not stop.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// A component or port cannot go to other middlewares.
    #[error(transparent)]
    Move(#[from] MoveError),
    /// A connection cannot be made.
    #[error("{}", .0.sentence())]
    Connect(#[from] ConnectError),
    /// A connection cannot be taken away.
    #[error(transparent)]
    Disconnect(ConnectError),
    /// The other side of a connection did not come in time.
    #[error("nothing after {:.1} s: {}", .after.as_secs_f64(), .source.sentence())]
    Absent {
        /// How long it was waited for.
        after: Duration,
        /// What is not there.
        source: ConnectError,
    },
    /// A component does not take a request.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The service that was to be started is over as soon as it ran.
    #[error("{component}/{service} is {kind}: name it in [[call]]")]
    NoActivity {
        /// Of which component.
        component: String,
        /// Its name.
        service: String,
        /// `an attribute` or `a function`.
        kind: &'static str,
    },
    /// What was called ended with an exception.
    #[error("it ended with {0}")]
    Exception(String),
    /// The daemon was asked to stop meanwhile.
    #[error("the daemon stops")]
    Stopping,
}

/// A component or port stays on the middlewares it is on.
#[derive(Debug, thiserror::Error)]
pub enum MoveError {
    /// The component was unloaded.
    #[error("{0} does not run")]
    NotThere(String),
    /// A middleware refused, or a codel does not return.
    #[error(transparent)]
    Bind(#[from] BindError),
}

/// Something that a step did stays as it is.
#[derive(Debug, thiserror::Error)]
pub(super) enum UndoError {
    /// The activity that it started.
    #[error("{0}, which does not end")]
    Endless(String),
    /// What a service did, since none is known that does the contrary.
    #[error("{0}")]
    Final(String),
    /// An attribute, which refuses the inputs it had.
    #[error("{step}: {source}")]
    Request { step: String, source: RequestError },
    #[error(transparent)]
    Move(#[from] MoveError),
    /// A connection that was made.
    #[error(transparent)]
    Disconnect(#[from] ConnectError),
    /// A connection that was taken away.
    #[error("{entry}: {}", .source.sentence())]
    Connect { entry: String, source: ConnectError },
}
