//! Ports and services over zenoh, usable by any zenoh peer.
//!
//! The following uses only plain zenoh. If a prefix is configured, `PREFIX/` precedes each key.
//!
//! **Ports.** Key `<instance>/<port>` (`demo/position`, `demo/poses/left`). A sample is a CDR
//! message: 4 bytes of encapsulation (`00 01 00 00`), then XCDR1, little endian. Its encoding is
//! `application/cdr;<type>;digest=<digest>`. Its attachment has 16 bytes: the mark of the writer
//! and the number of the sample, each a `u64`, little endian. A `get` of the key returns the last
//! value. Samples of others need neither encoding nor attachment: whatever can be decoded is
//! accepted.
//!
//! **Services.** A `get` of `<instance>/<service>` with the input as a CDR message. Attributes and
//! functions reply once, with the output. Activities reply several times (request no consolidation,
//! or only the last reply arrives); the attachment of a reply tells which it is: `accepted`
//! (payload: the activity's id in decimal), `feedback` (payload: name of the state), `result`
//! (payload: the output). A `get` of `<instance>/<service>/cancel` with that id as payload
//! interrupts the activity. Exceptions are error replies in JSON: `{"exception":
//! "::demo::TOO_FAR_AWAY", "detail": {..}}`; a request that fails before the service runs gets
//! `{"error": "types" | "serialization" | "gone" | "failed", "detail": ".."}`.
//!
//! **Discovery.** Liveliness tokens
//! `@genom/<pub|sub|srv>/<session>/<n>/<digest>/<types>/<address>`; `<types>` is percent-encoded;
//! the digest of a service is `<input>-<output>-<parameters and exceptions>`. Of foreign programs,
//! only their sessions are visible, and whether somebody reads a port. zenoh does not announce
//! publishers to peers. Its admin space lists subscribers and queryables, but querying it can hang
//! a session of zenoh 1.10 if others declare something at that moment. Ports can be connected to
//! foreign keys nevertheless.
//!
//! **Daemons.** Liveliness tokens `@genom/daemon/<session>/<name>`; a `get` of `@genom/rpc/<name>`
//! carries a request to the control plane of that daemon, and its reply.

#![forbid(unsafe_code)]

mod arrival;
mod backend;
mod client;
mod core;
mod daemons;
mod error;
mod graph;
mod inbox;
mod keys;
mod options;
mod ports;
mod reach;
mod relay;
mod rendezvous;
mod sending;
mod service;
mod services;
mod settings;
mod strangers;
mod trouble;
mod wire;

pub use backend::Zenoh;
pub use error::SessionError;
pub use options::{Mode, Options, Tls};
pub use rendezvous::default_directory;
