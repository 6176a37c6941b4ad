//! The process of a gateway: a middleware that is open here, for the proxies that connect.
//!
//! Each that connects is a [`guest`](guest::Guest): a thread hears what it says ([`talk`]), another
//! one sends it samples and messages, and what takes time is done on others.

mod gathered;
mod guest;
mod hall;
mod held;
mod mouth;
mod opening;
mod questions;
mod requests;
mod talk;

pub use hall::{Listening, Server};
