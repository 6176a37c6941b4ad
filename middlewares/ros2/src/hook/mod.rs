//! Functions of the C library that this crate defines for the whole program, for the sake of
//! RustDDS's threads: what they receive is looked at first, and signals do not end them.
//!
//! RustDDS offers no place for either. A program's own definition goes before that of the C
//! library; for all other threads these do what the C library's do. All unsafe code of this crate
//! is here.

#![allow(unsafe_code, reason = "defines functions of the C library")]

mod receive;
mod threads;
mod wait;

use std::sync::Arc;

use crate::guard::{Limits, Tally};

/// Has the guard look at what participants receive that are made in a domain from now on.
pub(crate) fn guard(domain: u16, limits: Limits) -> Arc<Tally> {
    receive::link();
    wait::link();
    receive::guard(domain, limits)
}
