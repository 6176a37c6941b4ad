//! Formulas of past-time temporal logic with bounds: what must hold at each event that a formula
//! names.

mod parse;
mod tree;
mod word;

pub(super) use parse::Parser;
pub use parse::{MOST_PARTS, MOST_TEXT, NoFormula};
pub use tree::{Formula, Within};
pub use word::{Atom, What};
