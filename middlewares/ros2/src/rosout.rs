//! `/rosout`, on which ROS nodes log: the entries of components that are nodes here.
//!
//! One writer of the process serves all its nodes; the entry says which one logged it, by the name
//! that rcl gives the node's logger (`lab.arm.demo`). Late readers get the latest entry.

use std::sync::{Arc, OnceLock};

use genom_middleware::{LogEntry, LogLevel};
use ros2_client::Log;
use ros2_client::builtin_interfaces::Time;

use crate::names::{self, TypeName};
use crate::rmw::{EndError, Named, TopicWriter};
use crate::ros::Ros;
use crate::typed;

/// The writer, once there was an entry.
#[derive(Default)]
pub(crate) struct Rosout(OnceLock<Option<Writer>>);

struct Writer {
    writer: Arc<dyn TopicWriter>,
    _belonging: Box<dyn Send + Sync>,
}

impl Writer {
    fn open(ros: &Ros) -> Result<Self, EndError> {
        let ty = TypeName::new("rcl_interfaces", "msg", "Log");
        let hash = ros.masquerades.hash_of_foreign(&ty);
        let of = Named { name: "rosout".to_owned(), ty, hash };
        let node = names::own_node();
        let writer = ros.rmw.writer(&node, &of, true)?;
        let belonging = ros.rmw.belong(&node, writer.entities());
        Ok(Self { writer, _belonging: belonging })
    }
}

impl Rosout {
    /// Publishes an entry of a component that is a node here.
    pub(crate) fn put(&self, ros: &Ros, entry: &LogEntry) {
        let node = names::token(&entry.instance);
        if !ros.rmw.has_node(&node) {
            return;
        }
        let open = || match Writer::open(ros) {
            Ok(writer) => Some(writer),
            Err(why) => {
                tracing::warn!("components do not log on /rosout: {why}");
                None
            }
        };
        let Some(Writer { writer, .. }) = self.0.get_or_init(open) else { return };
        let parts = ros.options.namespace.split('/').filter(|part| !part.is_empty());
        let log = Log {
            stamp: Time::from_nanos(entry.time),
            level: match entry.level {
                LogLevel::Debug => Log::DEBUG,
                LogLevel::Info => Log::INFO,
                LogLevel::Warn => Log::WARN,
                LogLevel::Error => Log::ERROR,
            },
            name: parts.chain([node.as_str()]).collect::<Vec<_>>().join("."),
            msg: entry.message.clone(),
            file: String::new(),
            function: entry.place.clone(),
            line: 0,
        };
        typed::encode(&log).into_iter().for_each(|body| writer.send(None, body));
    }
}
