//! The contract of a middleware: what the runtime may ask of any of them.
//!
//! A middleware moves [`Record`](genom_types::Record)s between ports by address. Nothing here
//! says how: topics, keys and segments are each backend's own affair.

#![forbid(unsafe_code)]

pub mod address;
pub mod error;
pub mod port;

pub use address::Address;
pub use error::{DiscoverError, OpenError, PublishError, ReadError};
pub use port::{
    Capabilities, Endpoint, EndpointKind, Middleware, Policy, Publisher, Reading, Subscription,
};
