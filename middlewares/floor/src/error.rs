//! Why a bare middleware could not be measured.

use std::io;

/// A bare middleware could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum FloorError {
    /// The middleware's own library refuses.
    #[error("bare {middleware}: {why}")]
    Middleware {
        /// Its name.
        middleware: &'static str,
        /// What the library says.
        why: String,
    },
    /// No value arrived from the writing process at all.
    #[error("no value arrived at the other process within {0} s")]
    Silent(u64),
    /// The other process failed, or cannot be started.
    #[error("the other process: {0}")]
    Process(#[from] io::Error),
    /// It was asked to end.
    #[error("interrupted")]
    Interrupted,
    /// The command line is not what `genomctl bench` writes.
    #[error("expected: --floor local|shm|zenoh|ros2 DIRECTORY BYTES PERIOD_NS VALUES")]
    Usage,
}

impl FloorError {
    /// What the library of a middleware says.
    pub(crate) fn of(middleware: &'static str) -> impl FnOnce(String) -> Self {
        move |why| Self::Middleware { middleware, why }
    }
}
