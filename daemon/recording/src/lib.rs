//! Recordings as MCAP files: writes those that `genomctl record` receives and those that a black box
//! leaves, and reads them, whole or not.

#![forbid(unsafe_code)]

mod file;
mod read;
mod replay;
mod room;

pub use file::{ChannelSummary, Recorder, WriteError};
pub use read::error::ReadError;
pub use read::walk::{Extent, Part, records, walk};
pub use read::{Glance, Recorded, Recording, glance};
pub use replay::{MOST_APART, inport, same_type};
