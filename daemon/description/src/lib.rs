//! The `.gen` language: text to checked component model and diagnostics.
//!
//! Reading never fails: it returns what could be understood and everything there is to say
//! about it. This crate starts no thread, opens no socket and loads no code; the only I/O is
//! reading the files a description includes, and running pkg-config for `#pragma requires`.

#![forbid(unsafe_code)]

mod absent;
mod check;
pub mod diagnostic;
mod lex;
pub mod model;
pub mod navigate;
pub mod parse;
pub mod preprocess;
mod ptoken;
pub mod source;
pub mod syntax;
pub mod token;
pub mod tools;

mod read;

pub use read::{Analysis, Options, read, read_files, read_text};
