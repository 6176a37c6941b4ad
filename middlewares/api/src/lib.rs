//! The contract of a middleware: what the runtime may ask of any of them.
//!
//! A middleware moves [`Record`](genom_types::Record)s between ports, and requests between
//! callers and services, by address. Nothing here says how: topics, keys and segments are each
//! backend's own affair.
//!
//! A backend implements [`Middleware`] and [`Ports`], and of [`Services`], [`Discovery`] and
//! [`Relay`] what it has; [`Backend`] says how it is opened. `docs/backend.md` shows how one is written; the crate
//! `genom-conformance` states what all of them must hold, as tests, and `genom-kit` has parts that
//! most need.

#![forbid(unsafe_code)]

pub mod address;
pub mod backend;
pub mod describe;
pub mod discovery;
pub mod error;
pub mod middleware;
pub mod port;
pub mod quality;
pub mod relay;
pub mod reply;
pub mod service;

pub use address::Address;
pub use backend::Backend;
pub use discovery::{Discovery, Endpoint, EndpointKind, Obstacle, Stranger};
pub use error::{CallError, DiscoverError, NoForeignName, OpenError, PublishError, ReadError};
pub use middleware::{Capabilities, Middleware, Refused};
pub use port::{Policy, PortSpec, Ports, Publisher, Reading, Subscription};
pub use quality::Quality;
pub use relay::{AnnounceError, AskError, OnRequest, Relay};
pub use reply::{ActivityId, Outcome, Replies};
pub use service::{Client, Running, Served, ServiceHandler, ServiceKind, ServiceType, Services};
