//! Who is there: our ends, and those of others as DDS and their daemons tell.

mod claim;
mod ends;
mod known;
mod shown;

pub(crate) use claim::{Belonging, Claim};
pub(crate) use ends::{Entities, Found, Made, Service, Verdict, Wanted};
pub(crate) use known::Graph;
