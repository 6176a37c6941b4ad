//! What a port of a component is tied to, and what passes there.
//!
//! Codels hold a [`Fan`] or a [`Tap`] for as long as they run; the ends behind it, on whatever
//! middlewares, are exchanged meanwhile. What passes is counted ([`gauge`]) and may be recorded
//! ([`tape`]). Nothing here knows which middlewares there are, how a port was asked for, or who
//! looks at it.

#![forbid(unsafe_code)]

pub mod dates;
mod fan;
mod feeds;
pub mod gauge;
mod key;
mod tap;
pub mod tape;

pub use fan::{Ends, Fan};
pub use feeds::{Feed, Feeds};
pub use key::PortKey;
pub use tap::Tap;
