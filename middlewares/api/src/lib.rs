//! The contract of a middleware: what the runtime may ask of any of them.
//!
//! A middleware moves [`Record`](genom_types::Record)s between ports, and requests between
//! callers and services, by address. Nothing here says how: topics, keys and segments are each
//! backend's own affair. [`conformance`] states what every backend must hold, as tests.

#![deny(unsafe_code)]

pub mod address;
pub mod bell;
pub mod conformance;
pub mod describe;
pub mod error;
pub mod index_ring;
pub mod mailbox;
pub mod port;
pub mod prompt;
pub mod quality;
pub mod relay;
pub mod reply;
pub mod service;
pub mod spares;

pub use address::Address;
pub use error::{CallError, DiscoverError, OpenError, PublishError, ReadError};
pub use port::{
    Capabilities, Endpoint, EndpointKind, Middleware, Policy, Publisher, Reading, Refused,
    Stranger, Subscription,
};
pub use quality::{Obstacle, Quality};
pub use relay::{AnnounceError, AskError, OnRequest, Relay};
pub use reply::{ActivityId, Outcome, Replies};
pub use service::{Client, Running, Served, ServiceHandler, ServiceKind, ServiceType};
