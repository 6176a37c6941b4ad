//! Properties of a component, and whether they hold.

mod check;
mod graph;
mod order;
mod parts;
mod untimed;
mod verdict;

pub use check::Report;
pub(crate) use order::needed;
pub use verdict::{Finding, Property, Verdict};
