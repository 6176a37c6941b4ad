//! Ports and services over zenoh, readable by any zenoh peer.
//!
//! Everything below is plain zenoh; `PREFIX/` stands before each key when one is configured.
//!
//! **Ports.** Key `<instance>/<port>` (`demo/position`, `demo/poses/left`). A sample is a CDR
//! message: 4 bytes of encapsulation (`00 01 00 00`), then XCDR1, little endian. Its encoding is
//! `application/cdr;<type>;digest=<digest>`. The attachment, 16 bytes, is the writer's mark and
//! the number of the sample, both `u64` little endian. A `get` of the key gives the last value.
//! Samples of others need neither encoding nor attachment: what decodes is accepted.
//!
//! **Services.** A `get` of `<instance>/<service>` with the input as CDR message. Attributes and
//! functions reply once, with the output. Activities reply several times (ask for no
//! consolidation, or see the last one only); the attachment of a reply says which it is:
//! `accepted` (payload: the number of the run in decimal), `feedback` (payload: the state's
//! name), `result` (payload: the output). A `get` of `<instance>/<service>/cancel` with that
//! number as payload interrupts the run. Exceptions are error replies in JSON:
//! `{"exception": "::demo::TOO_FAR_AWAY", "detail": {..}}`; a request that did not get as far
//! gives `{"error": "types" | "serialization" | "gone" | "failed", "detail": ".."}`.
//!
//! **Discovery.** Liveliness tokens `@genom/<pub|sub|srv>/<session>/<n>/<digest>/<types>/<address>`,
//! `<types>` with percent escapes; the digest of a service is `<input>-<output>-<parameters and
//! exceptions>`.
//! Of other programs, sessions show, and that somebody reads a port. zenoh tells peers of no
//! publishers, and its admin space, which lists subscribers and queryables, can hang a session of
//! 1.10 when it is asked while others declare something. Their keys can be connected to all the same.
//!
//! **Daemons.** Liveliness tokens `@genom/daemon/<session>/<name>`; a `get` of
//! `@genom/rpc/<name>` carries a request to the control plane of that daemon, and its reply.

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
mod wire;

pub use backend::Zenoh;
pub use error::SessionError;
pub use options::{Mode, Options, Tls};
pub use rendezvous::default_directory;
