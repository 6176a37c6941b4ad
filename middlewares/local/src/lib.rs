//! Ports and services within one process.
//!
//! Samples are exchanged without locks in their C layout, without encoding: the writer makes one
//! copy however many readers there are, and each reader makes one. Services are plain function
//! calls.
//!
//! All `unsafe` code is in `exchange`.

mod backend;
mod exchange;
mod lane;
mod opened;
mod options;
mod ports;
mod services;

pub use backend::Local;
pub use options::Options;
