//! Formulas of users about runs: what they say, and whether it holds.

mod atom;
mod comes;
mod formula;
mod past;

pub(crate) use atom::Atom;
pub use formula::Formula;
pub(crate) use formula::Term;
pub use genom_temporal::FormulaError;
pub(crate) use genom_temporal::Join;
