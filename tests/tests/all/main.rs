//! The black-box tests: real daemons and commands, run as users run them.
//!
//! They are one program, so that it is linked only once; folders are named after what they test.
//! One folder, file or test: `cargo test --workspace --test all -- wiring::moves`.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests fail them, and the message names the step"
)]

mod backends;
mod book;
mod cells;
mod cli;
mod components;
mod control_plane;
mod deployment;
mod editors;
mod embedding;
#[path = "../../src/siege/forger.rs"]
mod forger;
mod foxglove;
mod freezing;
mod gateways;
mod lua;
mod process;
mod projects;
mod python;
mod reload;
mod runners;
mod scenarios;
mod tree;
mod web;
mod wiring;
