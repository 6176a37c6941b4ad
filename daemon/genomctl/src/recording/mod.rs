//! Recordings: takes the daemon's frames apart, and reads MCAP files.

pub(crate) mod error;
pub(crate) mod frames;
pub(crate) mod reader;
pub(crate) mod walk;
