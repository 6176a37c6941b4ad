//! Recordings: converts the daemon's frames to MCAP files and back.

pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod frames;
pub(crate) mod reader;
pub(crate) mod room;
pub(crate) mod walk;
