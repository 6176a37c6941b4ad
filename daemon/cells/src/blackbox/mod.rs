//! The black box of a daemon: what its processes did last, and when that is written.
//!
//! Each process writes to a memory of its own (`genom_blackbox`), which the daemon made and holds
//! open. A cell gets it with its standard input, before it runs anything. When there is a reason,
//! the daemon reads them all and writes a file: of a crash into the report, of anything else into
//! the directory of section `[blackbox]`. Nothing is asked of the processes for that.

mod boxes;
mod gather;
mod lease;
mod reasons;
mod write;

pub use boxes::BlackBoxes;
pub use lease::Lease;
pub(crate) use lease::{Lent, lend};
pub use write::SaveError;
