//! What of a machine keeps components from running well, and what to do about it.
//!
//! Everything is read from files below one directory, `/` or a copy of some other machine's, so
//! that each finding can be tested; what only a live machine can tell is in `live`.

mod files;
mod finding;
mod live;
mod machine;
mod memory;

pub(crate) use files::findings;
pub(crate) use finding::{Finding, Level};
pub(crate) use live::live;
pub(crate) use machine::Machine;
