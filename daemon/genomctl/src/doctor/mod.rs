//! Finds what keeps components from running well on a machine, and what to do about it.
//!
//! Most findings come from files below one directory, `/` or a copy of another machine's files, so
//! that each can be tested; findings that need the live machine are in `live`.

mod files;
mod finding;
mod live;
mod machine;
mod memory;

pub(crate) use files::findings;
pub(crate) use finding::{Finding, Level};
pub(crate) use live::live;
pub(crate) use machine::Machine;
