//! Parts that most middlewares need between real-time threads and a network.
//!
//! A codel's `write` must neither wait nor allocate, and what a network's library does takes what
//! time it likes. Between the two stand, outgoing, an [`outlet`] of encoded samples and a thread
//! that sends ([`sender`]); incoming, a [`mailbox`] that the library's thread fills, and an
//! [`intake`] that decodes for the codel's `read`. A backend takes of this what fits it; none has
//! to.

#![deny(unsafe_code)]

pub mod bell;
mod busy;
pub mod index_ring;
pub mod intake;
pub mod lines;
pub mod mailbox;
pub mod outlet;
pub mod prompt;
mod relief;
pub mod sender;
mod shared;
pub mod spares;
