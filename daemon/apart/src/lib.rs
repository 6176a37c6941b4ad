//! Daemons for one purpose, apart from everything else on the machine: for `genomctl bench` and
//! `genomctl test`, which start them and talk to them.
//!
//! [`Private`] has what such a daemon uses alone, and writes its configuration; a
//! [`Program`](process::Program) is a process that ends with the value.

#![forbid(unsafe_code)]

mod private;
pub mod process;

pub use private::{NotWritten, Private, entries, set, within};
