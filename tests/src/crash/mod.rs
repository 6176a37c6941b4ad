//! Ends a daemon at chosen system calls, and looks at what its successor and its peers make of
//! what it leaves.
//!
//! A daemon runs under `ptrace` with a seccomp filter that stops it before each call by which a
//! program changes files; of those the ones count that touch shared memory. `Course` is what the
//! daemon goes through meanwhile, `Plan` where it ends, `Outcome` what came of it, `Toll` what came of
//! all points of a phase.

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
