//! ROS 2 holds what every middleware must hold.

#![allow(
    clippy::expect_used,
    clippy::panic,
    reason = "this is test code, also outside of test functions"
)]
mod world;

use world::Domain;

genom_middleware::conformance! { ros2: Domain::new() }
