//! The middleware as processes see it that use a gateway.
//!
//! A [`Proxy`] keeps a book of all that is open ([`book`]). Its thread ([`link`]) reaches the
//! gateway, opens what is in the book, and reads what comes back; when the connection ends, it does
//! so again with the next gateway.

mod book;
mod core;
mod hearing;
mod lines;
mod link;
mod middleware;
mod ports;
mod questions;
mod services;

pub use core::{Closed, Proxy};
