//! Ends a daemon at chosen system calls, and checks how its successor and its peers cope with what
//! it left.
//!
//! A daemon runs under `ptrace` with a seccomp filter that stops it before each call that can
//! change files; only calls that affect shared memory are counted. `Course` is what the daemon does
//! meanwhile, `Plan` says where it ends, `Outcome` is the result for one point, and `Toll` the
//! result for all points of a phase.

mod course;
mod outcome;
mod stage;
mod toll;
mod trace;
mod watched;

pub use course::Phase;
pub use outcome::Outcome;
pub use stage::{Plan, Stage};
pub use toll::{Points, Toll};
pub use watched::{End, Step};
