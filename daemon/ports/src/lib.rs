//! The data path of ports: what codels write to and read from.
//!
//! Codels hold a [`Fan`] (out port) or a [`Tap`] (in port) for as long as they run; the publishers
//! and subscriptions behind it can be exchanged for those of other middlewares meanwhile. Samples
//! are counted ([`gauge`]) and may be recorded ([`tape`]). [`Needs`] counts who needs a port on a
//! middleware that it is not on by itself. Which middlewares exist, and how
//! connections are requested, is the business of other crates.

#![forbid(unsafe_code)]

pub mod dates;
mod fan;
mod feeds;
pub mod gauge;
mod held;
mod key;
mod needs;
mod tap;
pub mod tape;

pub use fan::{Ends, Fan};
pub use feeds::{Feed, Feeds};
pub use key::PortKey;
pub use needs::{Need, Needs};
pub use tap::Tap;
