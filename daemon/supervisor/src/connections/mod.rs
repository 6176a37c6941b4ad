//! Connections: made, looked at, moved between middlewares and taken away.
//!
//! [`Connections`] is the one way to any of this. It finds out whether a name is that of an in port
//! or of a remote, and what deployments declared follows what somebody asks for.

mod calls;
mod core;
mod declared;
mod error;
mod facade;
pub mod feed;
mod find;
mod keep;
mod last;
mod moving;
mod opening;
mod port;
mod serve;
mod service;

pub use core::{Connections, Patience, Wanted};
pub use error::{ConnectError, Kind};
pub use find::{publishes, serves};
pub(crate) use keep::watch;
pub use opening::{BindError, Opening};
