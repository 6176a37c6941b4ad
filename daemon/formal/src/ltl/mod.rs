//! Formulas of users about runs: what they say, and whether it holds.

mod atom;
mod comes;
mod formula;
mod past;

pub use atom::Atom;
pub use formula::{Formula, Term};
pub use genom_temporal::FormulaError;
pub use genom_temporal::Join;
