//! Stands between the network and RustDDS, which does not check what it receives: [`guard`] makes
//! every datagram that a participant receives pass a filter first.

#![deny(unsafe_code)]

mod filter;
mod flight;
mod hook;

pub use filter::{Limits, Reason, Tally};
pub use flight::Flight;
pub use hook::guard;
