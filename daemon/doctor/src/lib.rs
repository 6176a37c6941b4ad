//! Finds what keeps components from running well, and what to do about it: on a machine, and in a
//! daemon.
//!
//! Findings about a machine come from files below one directory, `/` or a copy of another machine's
//! files, so that each can be tested; one is a test of the network. Findings about a daemon come from
//! what its control plane answers ([`Seen`]). `genomctl doctor` works without a daemon, and a daemon
//! answers `GET /doctor`: both say what stands here.

#![forbid(unsafe_code)]

mod codels;
mod daemon;
mod files;
mod machine;
mod memory;
mod multicast;
mod ros;

pub use daemon::{Seen, of_daemon};
pub use files::of_files;
pub use machine::Machine;
pub use multicast::multicast;
