//! Codels of `lang "c++"` components, against the header that `genomctl header --lang c++` writes.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // helpers are no test functions

mod axis;
mod behind;
mod ports;
mod refused;
#[path = "../support/mod.rs"]
mod support;
mod values;
