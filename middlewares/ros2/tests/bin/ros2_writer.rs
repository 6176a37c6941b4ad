//! Writes demo/position on ROS 2 until it is killed: the peer of a test.

#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "part of a test")]

use std::io::Read;

use genom_middleware::conformance::samples::{numbered, state};
use genom_middleware::{Address, Middleware};
use genom_ros2::{Options, Ros2};

/// Called with the domain. Ends with its standard input.
fn main() {
    let domain = std::env::args().nth(1).unwrap().parse().unwrap();
    let ros2 = Ros2::open(&Options { domain, ..Options::default() }).unwrap();
    let mut writer = ros2.publisher(&Address::new("demo", "position"), &state()).unwrap();
    writer.publish(&numbered(9)).unwrap();
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}
