//! Functions of the C library that this crate overrides in the whole program for RustDDS's threads:
//! `recvmsg`, so that the guard sees what they receive, `sendto`, so that what they send wrongly is
//! mended, and `epoll_wait`, so that signals do not end them.
//!
//! RustDDS has no interface for any of this. A definition in the program takes precedence over the C
//! library's; on all other threads the functions behave as the originals do. All unsafe code of
//! this crate is in this module.

#![allow(unsafe_code, reason = "defines functions of the C library")]

mod address;
mod next;
mod receive;
mod send;
mod since;
mod threads;
mod wait;

use std::sync::Arc;

use crate::filter::{Limits, Tally};

/// Makes the guard filter what participants receive that are created in this domain from now on.
pub fn guard(domain: u16, limits: Limits) -> Arc<Tally> {
    receive::link();
    send::link();
    wait::link();
    receive::guard(domain, limits)
}
