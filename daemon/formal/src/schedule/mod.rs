//! Whether tasks end their cycles in time, from sums instead of states: response-time analysis.
//!
//! Bounds are safe and found at once, for any number of requests; [`timed`](crate::timed) is exact
//! within its bounds, and takes a processor for each task. `docs/verify.md` has the formulas.

mod advice;
mod alive;
mod changes;
mod contexts;
mod cycle;
mod machine;
mod processors;
mod report;
mod text;
mod ways;

pub use changes::Change;
pub use machine::{Machine, OnMachine, Placed, Threads};
pub use report::{Called, Cause, Processors, Schedule, Scheduled, Waits};
