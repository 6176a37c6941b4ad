//! The middlewares a daemon is built with, by name.
//!
//! [`known`] lists them; no other place names them. [`Backends`] reads the options of each, opens
//! one when it is first needed, and keeps it open.

#![forbid(unsafe_code)]

mod backends;
mod known;
mod masquerade;

pub use backends::{Backends, Gateways};
pub use known::{
    BackendError, Known, Sections, check, check_gateway, check_options, known, places,
};
pub use masquerade::Masquerade;
