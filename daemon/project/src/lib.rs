//! Projects of components, on the developer's side: the files a new one consists of, codels for
//! what its description asks for, additions to both, the rules for `make`, and the headers,
//! pkg-config and CMake files that it is built against.
//!
//! Nothing here loads a library or talks to a daemon.

#![forbid(unsafe_code)]

pub mod add;
pub mod build;
mod c_source;
mod file;
mod makefile;
pub mod new;
pub mod sdk;
pub mod server;
pub mod skeleton;

pub use c_source::{Function, functions};
pub use file::{File, Written};
pub use makefile::dependencies;
