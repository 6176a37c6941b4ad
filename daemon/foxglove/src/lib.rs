//! A live source for Foxglove: what a daemon runs, over Foxglove's WebSocket protocol.
//!
//! | Foxglove | genomd |
//! |---|---|
//! | channel | a port, or a subject of the daemon: topic, encoding and schema as in recordings |
//! | client channel | values for an in port |
//! | service | a service of a component |
//! | parameter | an input of an attribute |
//! | connection graph | ports, connections, services |
//! | time | the virtual clock |
//!
//! It has no control plane of its own. All requests go to the daemon's, in the name of the client,
//! so that rights, limits, the log and cells are what they are for every other client ([`Inside`]).
//! Samples come from a recording of the ports that clients have subscribed to, of which there is one
//! for all of them, and none while nobody has.
//!
//! Messages are those of the official `foxglove` crate. Its server is not used: it binds its own
//! port, shows nobody the head of a request, so that pages elsewhere cannot be refused, has no
//! rights, limits what waits for a slow client in messages and not in bytes, and ends when the
//! process runs out of descriptors. Here the door is one of [`genom_doors`].
//!
//! `docs/foxglove.md` explains how to use it, and what keeps strangers out.

#![forbid(unsafe_code)]

mod advertised;
mod calls;
mod catalogue;
mod client;
mod feed;
mod gate;
mod graph;
mod hub;
mod inside;
mod keeper;
mod lock;
mod orders;
mod outbox;
mod parameters;
mod publishing;
mod reply;
mod server;
mod session;
mod terms;
mod upgrade;

#[allow(unused_imports, reason = "the documentation refers to it")]
use inside::Inside;
pub use server::{Foxglove, OpenError};
