//! A virtual clock that follows another clock instead of being stepped by requests: `/clock` of
//! ROS 2, on which simulators and `ros2 bag play --clock` publish their time
//! (`rosgraph_msgs/msg/Clock`).
//!
//! [`Source`] reads the topic; `course` says what a date means for the clock; [`follow`] steps the
//! cells and the components of the daemon, in a thread of its own.

#![forbid(unsafe_code)]

mod course;
mod follow;
mod source;

pub use follow::follow;
pub use source::{NoSource, Source};
