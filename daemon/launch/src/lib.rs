//! Components as managed nodes of ROS 2 (design article "Managed nodes", `lifecycle_msgs`): a launch
//! file, a lifecycle manager or `ros2 lifecycle set` decides when they are loaded and what they do.
//!
//! [`take`] takes such components out of a deployment, so that the daemon does not load them at its
//! start. [`serve`] offers the services of their nodes, for as long as the daemon runs: whether the
//! component is loaded or not. `machine` has the states and what leads from one to the next; `node`
//! does that through the control plane, as any client could; `messages` has the types.

#![forbid(unsafe_code)]

mod machine;
mod managed;
mod messages;
mod node;
mod serve;

pub use managed::{Managed, take};
pub use serve::{Nodes, NotServed, Offered, serve};
