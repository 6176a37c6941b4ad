//! Ties ports, remotes and services of components: to middlewares, and to one another.

mod calls;
pub(crate) mod connect;
pub(crate) mod feed;
pub(crate) mod publish;
pub(crate) mod remote;
pub(crate) mod requests;
pub(crate) mod serve;
pub(crate) mod switch;

pub(crate) use connect::{ConnectError, ConnectRequest};
