//! A topic of ROS itself that all components of a process publish on, through one writer.

use std::sync::{Arc, OnceLock};

use serde::Serialize;

use crate::names::TypeName;
use crate::rmw::{EndError, TopicWriter};
use crate::ros::Ros;
use crate::typed;

/// The writer, once there was something to tell. It belongs to the node of the process.
#[derive(Default)]
pub(crate) struct OwnTopic(OnceLock<Option<Writer>>);

struct Writer {
    writer: Arc<dyn TopicWriter>,
    _belonging: Box<dyn Send + Sync>,
}

impl Writer {
    fn open(ros: &Ros, name: &str, ty: TypeName, latched: bool) -> Result<Self, EndError> {
        let of = ros.of_ros(name.to_owned(), ty);
        let node = ros.names.own_node();
        let writer = ros.rmw.writer(&node, &of, latched)?;
        let belonging = ros.rmw.belong(&node, writer.entities());
        Ok(Self { writer, _belonging: belonging })
    }
}

impl OwnTopic {
    /// Publishes a message. `of` is the topic, package and name of its type; with `latched`, a late
    /// reader gets the latest message.
    pub(crate) fn put(
        &self,
        ros: &Ros,
        (topic, package, name): (&str, &str, &str),
        latched: bool,
        message: &impl Serialize,
    ) {
        let ty = TypeName::new(package, "msg", name);
        let open = || match Writer::open(ros, topic, ty, latched) {
            Ok(writer) => Some(writer),
            Err(why) => {
                tracing::warn!("nothing is published on /{topic}: {why}");
                None
            }
        };
        if let Some(Writer { writer, .. }) = self.0.get_or_init(open)
            && let Some(body) = typed::encode(message)
        {
            writer.send(None, body);
        }
    }
}
