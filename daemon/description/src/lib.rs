//! The `.gen` language: text to checked component model and diagnostics.
//!
//! Reading never fails: it returns what could be understood and everything there is to say
//! about it. This crate starts no thread, opens no socket and loads no code; the only I/O is
//! reading the files a description includes.

#![forbid(unsafe_code)]

pub mod diagnostic;
pub mod model;
pub mod token;
