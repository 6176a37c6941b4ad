//! Ports and services within one process.
//!
//! Samples go through a lock-free exchange in their C layout, without a codec: one copy by the
//! writer however many readers there are, one by each reader. Services are plain calls.
//!
//! The `unsafe` code is `exchange`.

mod backend;
mod exchange;
mod lane;
mod opened;
mod options;
mod ports;
mod services;

pub use backend::Local;
pub use options::Options;
