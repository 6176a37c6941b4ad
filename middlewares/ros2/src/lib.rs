//! Ports, services and activities as ROS 2 topics, services and actions.
//!
//! **Names.** Port `position` of instance `demo` is the topic `/demo/position` (DDS:
//! `rt/demo/position`), below a namespace if one is configured; an instance is a node. Characters
//! that ROS does not allow become `_xHH`. The type `::demo::state` is `demo/msg/State` (DDS:
//! `demo::msg::dds_::State_`); basic types are those of `std_msgs` (`double` is
//! `std_msgs/msg/Float64`); a type may go under the name of a ROS type of equal structure.
//!
//! **Samples.** CDR as [`genom_types::cdr`] says. Out ports are reliable and volatile unless the
//! configuration says otherwise of them; each reader that connects is sent the last value,
//! whatever it asked for (a best-effort reader of another make may miss it: DDS does not tell when
//! it is ready). Transient local, which would say so in DDS's own words, is an option: RustDDS
//! keeps all samples of several seconds for it and hands them all to those who come. An in port
//! asks for what all writers of its topic offer. Ends that are there and do not fit are told
//! (`quality`).
//!
//! **Services.** `<component>/srv/<Service>`: the request has the input's members, the response
//! `string genom_exception` (empty if none), `string genom_detail` (JSON) and the output's members.
//! Activities are actions, `<component>/action/<Activity>`: the goal is the input, the result is
//! like a response, feedback is `string genom_state`; an interrupted activity ends CANCELED, one
//! with another exception ABORTED. Callers that cancel a goal interrupt the activity; it ends
//! CANCELED also when it stops in an orderly way.
//!
//! **Parameters.** Attributes of one plain value are parameters of the node, too.
//!
//! A service or activity may masquerade as one of ROS of equal structure: then the foreign type is
//! used alone. An exception becomes `success = false` and `message = ::demo::NAME {detail}` where
//! the response has these two members (a service without outputs gets them for `SetBool` and
//! `Trigger`); else a service does not answer, which is logged, and an action ends ABORTED.
//! Feedback that is not one string is left out.
//!
//! **Who is there.** DDS's discovery names topics and types; daemons tell each other besides, on
//! the topic `genom_discovery_info`, the full types and digests of their ends: types of one name
//! that differ are refused. Of ROS nodes the name of the type is known, and since ROS 2 Iron its
//! hash, which `genomctl why` compares. ROS nodes are not told the hash of ours: it travels as
//! USER_DATA of an end, which RustDDS 0.15 reads and never sends; ROS connects without it, and
//! shows the type without hash (`ros2 topic info --verbose`).
//! ROS nodes see at once that a node is gone; topics and services that are closed they show until
//! the daemon ends (`farewell` says why). A daemon that is killed they show for 50 seconds more:
//! the lease that RustDDS announces for all its participants.

#![deny(unsafe_code)]

mod backend;
mod body;
mod channel;
mod client;
mod complaints;
mod core;
mod dds;
mod domain;
mod error;
mod farewell;
mod feed;
mod feeds;
mod goals;
mod graph;
mod guard;
mod hook;
mod inbox;
mod info;
mod lock;
mod masquerades;
mod meetings;
mod names;
mod news;
mod numbering;
mod obstacles;
mod options;
mod parameters;
mod ports;
mod post;
mod process;
mod quality;
mod receiver;
mod reunions;
mod runs;
mod sender;
mod server;
mod services;
mod told;
mod wire;
mod within;

pub use backend::Ros2;
pub use error::ParticipantError;
pub use options::{Networks, Options, OptionsError, Qos, ServiceMapping};
