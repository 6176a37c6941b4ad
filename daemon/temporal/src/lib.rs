//! Formulas of linear temporal logic (Pnueli: *The Temporal Logic of Programs*, 1977) with words for the
//! past, about whatever facts their user has; `docs/verify.md` has their text.

#![forbid(unsafe_code)]

mod parse;
mod term;

pub use parse::{Facts, FormulaError, NoFact, parse};
pub use term::{Join, Term};
