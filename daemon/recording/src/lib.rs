//! Recordings as MCAP files: writes those that `genomctl record` receives and those that a black box
//! leaves, reads them, whole or not, and makes bags of ROS 2 of them.

#![forbid(unsafe_code)]

mod bag;
mod file;
mod read;
mod replay;
mod room;

pub use bag::{BagError, BagTopic, Bagged, samples_of, write_bag};
pub use file::{ChannelSummary, Recorder, WriteError, written_by};
pub use read::error::ReadError;
pub use read::walk::{Extent, Part, records, walk};
pub use read::{Glance, Recorded, Recording, glance};
pub use replay::{MOST_APART, inport, same_type};
