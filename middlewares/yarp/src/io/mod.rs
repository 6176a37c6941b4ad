//! All connections of the middleware, on one thread that never waits for a peer.

mod commands;
mod connections;
mod dialed;
mod errands;
mod incoming;
mod reactor;

pub(crate) use commands::{Answer, Command, Io};
pub(crate) use connections::Around;
pub(crate) use errands::{Errand, Lost, Step};
pub(crate) use reactor::start;
