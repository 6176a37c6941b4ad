//! The middlewares a daemon is built with, by name.
//!
//! [`known`] lists them; no other place names them. Those of libraries ([`named`]) are added when a
//! daemon starts, and never by a request. [`Backends`] reads the options of each, opens
//! one when it is first needed, and keeps it open.

#![forbid(unsafe_code)]

mod backends;
mod known;
mod masquerade;
mod plugins;

pub use backends::{Backends, Gateways};
pub use known::{
    BackendError, Known, LIBRARY, Sections, check, check_gateway, check_options, known, places,
};
pub use masquerade::Masquerade;
pub use plugins::{PATH, has, named, of_path};
