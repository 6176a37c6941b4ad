//! Rules that need real threads and real time: what blocks, what waits, what hangs.

#![allow(clippy::unwrap_used, clippy::panic)]

mod hangs;
mod requests;
#[path = "../support/mod.rs"]
mod support;
mod ticks;
