//! The supervisor as a library: components run in this very process, without a control plane.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests fail them")]

mod example;
mod feeding;
mod masquerades;
mod moving;
mod own;
mod support;
