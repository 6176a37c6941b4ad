//! The interface between the runtime and a middleware.
//!
//! A middleware carries [`Record`](genom_types::Record)s between ports, and requests and replies
//! between callers and services. Both are identified by an [`Address`]. How a backend maps
//! addresses to its own topics, keys or segments is not visible here.
//!
//! A backend implements [`Middleware`] and [`Ports`]; [`Services`], [`Discovery`] and [`Relay`] are
//! optional; [`Backend`] says how it is opened. `docs/backend.md` shows how to write one. The crate
//! `genom-conformance` tests what every backend must provide, and `genom-kit` has parts that most
//! backends need.

#![forbid(unsafe_code)]

pub mod address;
pub mod backend;
pub mod describe;
pub mod diagnosis;
pub mod discovery;
pub mod error;
pub mod log;
pub mod middleware;
pub mod port;
pub mod quality;
pub mod relay;
pub mod reply;
pub mod service;

pub use address::Address;
pub use backend::Backend;
pub use diagnosis::{Diagnosis, Health, Part};
pub use discovery::{Discovery, Endpoint, EndpointKind, Obstacle, Stranger};
pub use error::{CallError, DiscoverError, NoForeignName, OpenError, PublishError, ReadError};
pub use log::{LogEntry, LogLevel};
pub use middleware::{Capabilities, Middleware, Refused};
pub use port::{Policy, PortSpec, Ports, Publisher, Reading, Subscription};
pub use quality::Quality;
pub use relay::{AnnounceError, AskError, OnRequest, Relay};
pub use reply::{ActivityId, Outcome, Replies};
pub use service::{Client, Running, Served, ServiceHandler, ServiceKind, ServiceType, Services};
