//! Requests that come as messages, passed on by others that nobody needs to trust.
//!
//! What passes is sealed by the client and the service that is meant (`genom_proof`): whoever passes
//! it on cannot read a token, ask in the client's name, or answer for the service.

mod desk;
mod sessions;
mod streams;

pub use desk::Desk;
