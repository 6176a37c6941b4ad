//! Ties ports, remotes and services of components: to middlewares, and to one another.

mod calls;
pub mod connect;
pub mod feed;
pub mod publish;
pub mod remote;
pub mod requests;
pub mod serve;
pub mod switch;

pub use connect::{ConnectError, ConnectRequest};
