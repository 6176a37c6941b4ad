//! The ROS 2 backend passes the conformance suite: over DDS, with either mapping of services, and
//! over zenoh.

#![allow(clippy::expect_used, reason = "test code, also outside of test functions")]

mod world;
#[path = "world/zenoh.rs"]
mod zenoh_world;

use genom_ros2::ServiceMapping;
use world::Domain;
use zenoh_world::Place;

genom_conformance::conformance! {
    ros2: Domain::new(ServiceMapping::Enhanced),
    cyclone: Domain::new(ServiceMapping::Cyclone),
    zenoh: Place::new(),
}
