//! Properties of a component, and whether they hold.

mod answer;
mod check;
mod followed;
mod graph;
mod order;
mod parts;
mod seen;
mod untimed;
mod verdict;
mod walks;

pub use check::Report;
pub(crate) use graph::stops_late;
pub(crate) use order::needed;
pub use verdict::{Finding, Property, Verdict};
