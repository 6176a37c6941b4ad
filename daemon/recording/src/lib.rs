//! Writes recordings as MCAP files: those that `genomctl record` receives, and those that a black
//! box leaves.

#![forbid(unsafe_code)]

mod file;
mod room;

pub use file::{ChannelSummary, Recorder, WriteError};
