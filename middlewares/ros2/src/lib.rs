//! Ports, services and activities as ROS 2 topics, services and actions, over DDS or zenoh.
//!
//! `rmw` is the interface between what is ROS (names, types, hashes, actions, parameters) and what
//! carries it: `dds` and `zenoh` implement it.
//!
//! **Names.** Port `position` of instance `demo` is the topic `/demo/position` (DDS:
//! `rt/demo/position`), below a namespace if one is configured; an instance is a node. Characters
//! that ROS does not allow become `_xHH`. The type `::demo::state` is `demo/msg/State` (DDS:
//! `demo::msg::dds_::State_`). Basic types are those of `std_msgs` (`double` is
//! `std_msgs/msg/Float64`). A type may masquerade as a ROS type of equal structure.
//!
//! **Samples.** CDR as described in [`genom_types::cdr`]. Out ports are reliable and volatile
//! unless configured otherwise. Each reader that connects is sent the last value, whatever
//! durability it requested (a foreign best-effort reader may miss it, because DDS does not tell
//! when it is ready). Transient local, DDS's own way to request this, is optional: for it, RustDDS
//! keeps all samples of several seconds and sends all of them to new readers. An in port requests
//! what all writers of its topic offer. Ends that cannot connect because of their QoS are reported
//! (`quality`).
//!
//! **Services.** `<component>/srv/<Service>`: the request has the input's members, the response has
//! `string genom_exception` (empty if none), `string genom_detail` (JSON) and the output's members.
//! Activities are actions, `<component>/action/<Activity>`: the goal is the input, the result has
//! the form of a response, and the feedback is `string genom_state`. An interrupted activity ends
//! CANCELED, one with another exception ABORTED. A client that cancels a goal interrupts the
//! activity, which then ends CANCELED even if it stopped in an orderly way.
//!
//! **Parameters.** Attributes with a single plain value are also parameters of the node, and every
//! node of a component has `use_sim_time`.
//!
//! **Types.** Each node of a component tells what the types are made of that it uses
//! (`get_type_description`).
//!
//! **Masquerades.** A service or activity may masquerade as a ROS one of equal structure; then only
//! the foreign type is used. An exception becomes `success = false` and `message = ::demo::NAME
//! {detail}` if the response has these two members (a service without outputs gets them for
//! `SetBool` and `Trigger`). Otherwise a service does not reply, which is logged, and an action
//! ends ABORTED. Feedback that is not a single string is not sent.
//!
//! **zenoh.** All as `rmw_zenoh_cpp` does it (ROS 2 Jazzy and later): topics and services are keys
//! `<domain>/<name>/<type>/<hash>`, each node and end has a liveliness token, and samples, requests
//! and replies carry number, time and gid. Ends of one name connect if type and hash are the same;
//! quality of service keeps none apart. Out ports keep their last value for all who ask for it:
//! nodes that request transient local, and in ports of daemons. Daemons tell each other full types
//! and digests by further tokens, `@genom_ros2/..`, so that types of equal members connect whatever
//! their names are. A killed daemon is gone from ROS's lists at once. Where no router runs, this
//! process is one. The rest of this page is about DDS.
//!
//! **Discovery.** DDS announces topics and names of types. Daemons also announce to each other, on
//! the topic `genom_discovery_info`, the full types and digests of their ends, so that different
//! types of the same name are refused. Of ROS nodes the name of the type is known and, since ROS 2
//! Iron, its hash, which `genomctl why` compares. ROS nodes do not get the hashes of our types: a
//! hash is sent as USER_DATA of an end, which RustDDS 0.15 reads but never sends. ROS connects
//! without it, and shows the type without a hash (`ros2 topic info --verbose`). ROS nodes notice at
//! once that a node is gone, but show closed topics and services until the daemon ends (`farewell`
//! says why). They show a killed daemon for 50 seconds: the lease that RustDDS announces for every
//! participant.

#![forbid(unsafe_code)]

mod backend;
mod body;
mod client;
mod conflict;
mod dds;
mod definitions;
mod descriptions;
mod diagnostics;
mod domain;
mod error;
mod goals;
mod inbox;
mod lock;
mod masquerades;
mod names;
mod nodes;
mod options;
mod own_services;
mod own_topic;
mod parameters;
mod port;
mod rmw;
mod ros;
mod rosout;
mod runs;
mod server;
mod services;
mod settled;
mod typed;
mod used;
mod within;
mod zenoh;

pub use backend::Ros2;
pub use error::ParticipantError;
pub use options::{Networks, Options, OptionsError, Qos, Rmw, ServiceMapping, ZenohOptions};
