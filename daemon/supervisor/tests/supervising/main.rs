//! Tests of the supervisor as a library: components run in the test's process, without a control
//! plane.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers fail tests")]

mod example;
mod feeding;
mod finding;
mod masquerades;
mod moving;
mod own;
mod support;
