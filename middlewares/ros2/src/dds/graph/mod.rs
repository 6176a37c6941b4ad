//! The graph: our ends, and those of others as DDS and their daemons announce them.

mod claim;
mod ends;
mod known;
mod shown;

pub(crate) use claim::Claim;
pub(crate) use ends::{Entities, Found, Made, Verdict, Wanted};
pub(crate) use known::Graph;
