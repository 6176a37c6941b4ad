//! What ROS 2's own tools may do with the components of a daemon: a launch file, a lifecycle manager
//! or `ros2 lifecycle set` leads them as managed nodes ([`take`], [`manage`]), and loads others into a
//! container ([`contain`]). Both act through the control plane, as any client could.
//!
//! `offer` serves what is answered in JSON as services of ROS nodes, and `table` has the types that
//! both need.

#![forbid(unsafe_code)]

mod container;
mod lifecycle;
mod offer;
mod table;

pub use container::{Container, contain};
pub use lifecycle::{Managed, manage, take};
pub use offer::{NotServed, Offered, Offers};
