//! Why a step of a deployment was not taken, or could not be taken back.

use std::time::Duration;

use crate::components::UnloadError;
use crate::components::request::RequestError;
use crate::connections::{BindError, ConnectError};
use crate::loading::LoadError;

/// Why a step of a deployment failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// A component could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A component could not be stopped.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// A component or port could not be moved.
    #[error(transparent)]
    Move(#[from] MoveError),
    /// A connection could not be made.
    #[error("{}", .0.sentence())]
    Connect(#[from] ConnectError),
    /// A connection could not be removed.
    #[error(transparent)]
    Disconnect(ConnectError),
    /// The other side of a connection did not appear in time.
    #[error("nothing after {:.1} s: {}", .after.as_secs_f64(), .source.sentence())]
    Absent {
        /// The time waited.
        after: Duration,
        /// Which side is missing.
        source: ConnectError,
    },
    /// A component refused a request.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The service to be started is not an activity, and would be over at once.
    #[error("{component}/{service} is {kind}: name it in [[call]]")]
    NoActivity {
        /// Instance name of the component.
        component: String,
        /// Name of the service.
        service: String,
        /// `an attribute` or `a function`.
        kind: &'static str,
    },
    /// The service ended with an exception.
    #[error("it ended with {0}")]
    Exception(String),
    /// The daemon was asked to stop meanwhile.
    #[error("the daemon stops")]
    Stopping,
}

/// Why a component or port was not moved.
#[derive(Debug, thiserror::Error)]
pub enum MoveError {
    /// The component was unloaded.
    #[error("{0} does not run")]
    NotThere(String),
    /// A middleware reported an error, or a codel does not return.
    #[error(transparent)]
    Bind(#[from] BindError),
}

/// An effect of a step that could not be undone.
#[derive(Debug, thiserror::Error)]
pub(super) enum UndoError {
    /// An activity that was started and does not end.
    #[error("{0}, which does not end")]
    Endless(String),
    /// The effect of a service that has no known inverse.
    #[error("{0}")]
    Final(String),
    /// An attribute that refused its previous inputs.
    #[error("{step}: {source}")]
    Request { step: String, source: RequestError },
    #[error(transparent)]
    Move(#[from] MoveError),
    /// A connection that could not be removed again.
    #[error(transparent)]
    Disconnect(#[from] ConnectError),
    /// A connection that could not be restored.
    #[error("{entry}: {}", .source.sentence())]
    Connect { entry: String, source: ConnectError },
}
