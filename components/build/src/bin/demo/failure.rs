//! Why the demonstration did not end at the goal.

use std::io;
use std::process::ExitStatus;

use genom_components::BuildError;

/// Why the demonstration did not end at the goal.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// Something does not compile.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A program cannot be started, or a pipe is broken.
    #[error("{what}: {source}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// genomd ended before it was ready.
    #[error("genomd did not start:\n{said}")]
    NotReady {
        /// What it said on standard error.
        said: String,
    },
    /// genomctl was refused, or the service ended with an exception.
    #[error("`genomctl {command}` failed: {said}")]
    Refused {
        /// What was asked.
        command: String,
        /// What it said on standard error.
        said: String,
    },
    /// A reply has another shape than expected.
    #[error("{what} cannot be read in `{found}`")]
    Unexpected {
        /// What was looked for.
        what: &'static str,
        /// What was there.
        found: String,
    },
    /// No end of the activity.
    #[error("nothing moved for {seconds} s")]
    Never {
        /// How long it was waited for.
        seconds: u64,
    },
    /// The activity ended elsewhere.
    #[error("the axis is at {position} m instead of {goal} m")]
    Elsewhere {
        /// Where it is.
        position: f64,
        /// Where it should be.
        goal: f64,
    },
    /// genomd did not stop as it should.
    #[error("genomd ended with {status}:\n{said}")]
    BadEnd {
        /// How it ended.
        status: ExitStatus,
        /// What it said on standard error.
        said: String,
    },
}

impl Failure {
    /// Says what was tried when the system refused.
    pub(crate) fn system(what: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::System { what, source }
    }
}
