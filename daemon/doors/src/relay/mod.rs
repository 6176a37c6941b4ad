//! Requests that arrive as messages, relayed by others that need not be trusted.
//!
//! Messages are sealed by the client and the service they are for (`genom_proof`): those who relay
//! them can neither read a token, nor make requests in the client's name, nor answer for the
//! service.

mod desk;
mod sessions;
mod streams;

pub use desk::Desk;
