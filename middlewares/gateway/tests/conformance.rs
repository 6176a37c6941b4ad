//! zenoh and ROS 2 pass the conformance suite through a gateway, both where each participant has
//! its own and where all share one.

mod world;

use world::{House, Kind};

genom_conformance::conformance! {
    zenoh: House::new(Kind::Zenoh, false),
    zenoh_shared: House::new(Kind::Zenoh, true),
    ros2: House::new(Kind::Ros2, false),
    ros2_shared: House::new(Kind::Ros2, true),
}
