//! Rules that need real threads and real time: blocking, waiting, hanging.

#![allow(clippy::unwrap_used, clippy::panic)]

mod hangs;
mod order;
mod requests;
#[path = "../support/mod.rs"]
mod support;
mod ticks;
