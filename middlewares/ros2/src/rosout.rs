//! `/rosout`, on which ROS nodes log: the entries of components that are nodes here.
//!
//! An entry says which of them logged it by the name that rcl gives the node's logger
//! (`lab.arm.demo`). Late readers get the latest entry.

use genom_middleware::{LogEntry, LogLevel};
use ros2_client::Log;
use ros2_client::builtin_interfaces::Time;

use crate::own_topic::OwnTopic;
use crate::ros::Ros;

/// The topic.
#[derive(Default)]
pub(crate) struct Rosout(OwnTopic);

impl Rosout {
    /// Publishes an entry of a component that is a node here.
    pub(crate) fn put(&self, ros: &Ros, entry: &LogEntry) {
        let node = ros.names.node(&entry.instance);
        if !ros.rmw.nodes().contains(&node) {
            return;
        }
        let log = Log {
            stamp: Time::from_nanos(entry.time),
            level: match entry.level {
                LogLevel::Debug => Log::DEBUG,
                LogLevel::Info => Log::INFO,
                LogLevel::Warn => Log::WARN,
                LogLevel::Error => Log::ERROR,
            },
            name: node.replace('/', "."),
            msg: entry.message.clone(),
            file: entry.file.clone(),
            function: entry.place.clone(),
            line: entry.line,
        };
        self.0.put(ros, ("rosout", "rcl_interfaces", "Log"), true, &log);
    }
}
