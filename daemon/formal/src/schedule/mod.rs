//! Whether tasks end their cycles in time, from sums instead of states: response-time analysis.
//!
//! Bounds are safe and found at once, for any number of requests; [`timed`](crate::timed) is exact
//! within its bounds, and takes a processor for each task. `docs/verify.md` has the formulas.

mod advice;
mod changes;
mod contexts;
mod cycle;
mod dearest;
mod known;
mod latest;
mod machine;
mod report;
mod startup;
mod walk;
mod ways;
mod window;

pub use changes::Change;
pub(crate) use dearest::Dearest;
pub use known::{Cause, Meanwhile};
pub(crate) use latest::CycleLength;
pub use machine::{Machine, OnMachine, Placed, Threads};
pub use report::{Called, Processors, Schedule, Scheduled, Waits};
pub(crate) use walk::{Does, Latest};
