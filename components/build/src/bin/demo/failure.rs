//! Errors of the demonstration.

use std::io;
use std::process::ExitStatus;

use genom_components::BuildError;

/// Why the demonstration failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// A program or component does not compile.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A program cannot be started, or a pipe is broken.
    #[error("{what}: {source}")]
    System {
        /// What was attempted.
        what: &'static str,
        /// The error of the system.
        source: io::Error,
    },
    /// genomd ended before it was ready.
    #[error("genomd did not start:\n{said}")]
    NotReady {
        /// Its standard error.
        said: String,
    },
    /// genomctl was refused, or the service ended with an exception.
    #[error("`genomctl {command}` failed: {said}")]
    Refused {
        /// The arguments of genomctl.
        command: String,
        /// Its standard error.
        said: String,
    },
    /// A reply does not have the expected form.
    #[error("{what} cannot be read in `{found}`")]
    Unexpected {
        /// What was expected.
        what: &'static str,
        /// What was found.
        found: String,
    },
    /// The activity did not end in time.
    #[error("nothing moved for {seconds} s")]
    Never {
        /// The time waited, in seconds.
        seconds: u64,
    },
    /// The activity ended at another position.
    #[error("the axis is at {position} m instead of {goal} m")]
    Elsewhere {
        /// The position, in metres.
        position: f64,
        /// The goal, in metres.
        goal: f64,
    },
    /// genomd did not end cleanly.
    #[error("genomd ended with {status}:\n{said}")]
    BadEnd {
        /// Its exit status.
        status: ExitStatus,
        /// Its standard error.
        said: String,
    },
}

impl Failure {
    /// Adds to an error of the system what was attempted.
    pub(crate) fn system(what: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::System { what, source }
    }
}
