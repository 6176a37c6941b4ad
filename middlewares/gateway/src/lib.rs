//! A middleware in a process of its own, so that what its library does with bytes from the network
//! ends no component.
//!
//! The process of the gateway opens the middleware and serves it on a private Unix socket
//! ([`Server`]). Other processes of the same daemon open a [`Proxy`], which is the same middleware
//! to them: each port, service and question goes to the gateway as a frame ([`wire`], [`words`]).
//! Real-time threads only fill and empty mailboxes; threads of the proxy carry them to the socket
//! and back.
//!
//! When the gateway ends, the proxy asks for the next one and opens all its ends again there
//! ([`proxy`]). Readers keep their last value meanwhile, writers go on, requests under way end with
//! an error.
//!
//! Frames rather than shared memory connect the two: a gateway that an attacker controls can then
//! do no more to a component than send it samples and requests.

#![forbid(unsafe_code)]

mod channel;
mod door;
mod place;
pub mod proxy;
mod server;
mod wire;
mod words;

pub use door::{Door, knock};
pub use place::{Reach, cell_of, middleware_of};
pub use proxy::{Closed, Proxy};
pub use server::{Listening, Server};
