//! Parts that most backends need between real-time threads and a network.
//!
//! A codel's `write` must not block or allocate, while a call of a network library may take any
//! time. So outgoing samples go from an [`out_port`] through an [`outlet`] of encoded samples to a
//! thread that sends them ([`sender`]). Incoming samples go into a [`mailbox`], which the library's thread fills, and
//! an [`intake`] decodes them when a codel calls `read`. A backend uses those parts that fit it.

#![deny(unsafe_code)]

pub mod bell;
mod busy;
pub mod complaints;
pub mod index_ring;
pub mod intake;
pub mod lines;
pub mod mailbox;
pub mod out_port;
pub mod outlet;
pub mod prompt;
mod relief;
pub mod sender;
mod shared;
pub mod spares;
