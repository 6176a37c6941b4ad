//! A component whose codels return what a script says, and that records all calls.

#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub(crate) mod closures;
mod plan;
pub(crate) mod scripted;
pub(crate) mod transcript;

use genom_runtime::Execution;

pub(crate) use plan::plan;

/// What executes the components of a test, if it does not choose itself.
pub(crate) fn execution() -> Execution {
    Execution::Threads
}
