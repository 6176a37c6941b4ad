//! Formulas of users about runs: what they say, and whether it holds.

mod atom;
mod comes;
mod formula;
mod parse;
mod past;

pub(crate) use atom::Atom;
pub use formula::Formula;
pub(crate) use formula::{Join, Term};
pub use parse::FormulaError;
