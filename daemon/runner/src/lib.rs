//! The daemon as a library that a runner loads (docs/runners.md), so that a cell runs codels in the
//! language of the runner: `python -m genom.runner` in the user's own interpreter, `genom-lua`.
//!
//! Nothing here is linked with a language. The runner starts [`foreign`] with functions of its own: one
//! makes C functions of the codels in a script, one forgets them, and one tells where a codel is. From
//! then on the process is a cell as any other one, and calls these codels as it calls those in C.

#![deny(unsafe_code)]

pub mod foreign;
mod loaded;
mod script;
