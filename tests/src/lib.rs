//! Shared by the black-box tests: runs daemons and commands as users do.
//!
//! It uses the programs through command lines and sockets only, and no code of theirs.

#![deny(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "part of tests: a failed step ends the test, and the message names it"
)]

pub mod bare;
pub mod browser;
mod build;
mod command;
pub mod conformance;
mod counts;
pub mod crash;
mod daemon;
pub mod faults;
pub mod fleet;
mod http;
mod many;
pub mod mesh;
pub mod pace;
pub mod python_client;
pub mod reloads;
pub mod siege;
mod signal;
mod transcript;
pub mod trial;
mod until;

pub use build::{component, copy_folder, files, fixture, path, program, release, repository};
pub use command::{Finished, Running, WATCHDOG};
pub use counts::{Counts, step};
pub use daemon::{Daemon, Home, Memory};
pub use http::{Events, Reply, connect, request};
pub use many::{Footprint, Many, processor_time};
pub use signal::signal;
pub use transcript::transcript;
pub use until::{until, until_answer};
