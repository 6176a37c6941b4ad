//! Opens a middleware in a library of its own: the host's side of `genom3/middleware.h`.
//!
//! [`Library::open`] opens the file and checks its table; [`Library::middleware`] opens the
//! middleware with its options, as one that implements the traits of [`genom_middleware`]. Queues,
//! policies and threads are of `genom-kit`: the library gets whole samples as bytes, and real-time
//! threads never enter it, unless it says that they may.
//!
//! Unsafe code is in `library`, `opening`, `calls` and `callbacks`.

#![deny(unsafe_code)]

mod callbacks;
mod calls;
mod describe;
mod error;
mod form;
mod given;
mod library;
mod listing;
mod lists;
mod middleware;
mod opening;
mod outlet;
mod ports;
mod relay;
mod reports;
mod services;

pub use error::LibraryError;
pub use library::Library;
