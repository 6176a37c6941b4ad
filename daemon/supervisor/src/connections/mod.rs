//! Connections: making, listing, moving and removing them.
//!
//! Everything goes through [`Connections`]. It finds out whether a name is that of an in port or of
//! a remote, and keeps the declarations of deployments consistent with later requests.

mod calls;
mod core;
mod declared;
mod elsewhere;
mod error;
mod facade;
pub mod feed;
mod find;
mod keep;
mod last;
mod moving;
mod opening;
mod over;
mod port;
mod serve;
mod service;
mod share;
mod stranded;

pub use core::{Connections, Patience, Wanted};
pub use elsewhere::between_processes;
pub use error::{ConnectError, Kind};
pub use find::{publishes, serves};
pub(crate) use keep::watch;
pub use opening::{BindError, Opening};
pub use stranded::{Stranded, stranded};
