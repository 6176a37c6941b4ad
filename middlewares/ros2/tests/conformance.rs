//! The ROS 2 backend passes the conformance suite, with either mapping of services.

mod world;

use genom_ros2::ServiceMapping;
use world::Domain;

genom_conformance::conformance! {
    ros2: Domain::new(ServiceMapping::Enhanced),
    cyclone: Domain::new(ServiceMapping::Cyclone),
}
