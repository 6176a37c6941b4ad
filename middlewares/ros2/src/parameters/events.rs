//! `/parameter_events`, on which each node tells which of its parameters were set.
//!
//! Attributes that are set in another way than as parameters are not told: the middleware does not
//! hear of it.

use std::sync::Arc;

use ros2_client::builtin_interfaces::Time;
use ros2_client::parameters::raw::{Parameter, ParameterEvent};

use crate::names::TypeName;
use crate::rmw::{EndError, Entities, TopicWriter};
use crate::ros::Ros;
use crate::typed;

/// The type of the topic.
pub(super) fn type_name() -> TypeName {
    TypeName::new("rcl_interfaces", "msg", "ParameterEvent")
}

/// What one node tells.
pub(super) struct Events {
    /// `/NAMESPACE/NODE`.
    node: String,
    writer: Arc<dyn TopicWriter>,
}

impl Events {
    /// `node` is the name of the node with its namespace.
    pub(super) fn open(ros: &Ros, node: &str) -> Result<Arc<Self>, EndError> {
        let of = ros.of_ros("parameter_events".to_owned(), type_name());
        let writer = ros.rmw.writer(node, &of, false)?;
        Ok(Arc::new(Self { node: format!("/{node}"), writer }))
    }

    pub(super) fn entities(&self) -> Entities {
        self.writer.entities()
    }

    /// These have been set.
    pub(super) fn changed(&self, changed_parameters: Vec<Parameter>) {
        if changed_parameters.is_empty() {
            return;
        }
        let event = ParameterEvent {
            stamp: Time::now(),
            node: self.node.clone(),
            new_parameters: Vec::new(),
            changed_parameters,
            deleted_parameters: Vec::new(),
        };
        typed::encode(&event).into_iter().for_each(|body| self.writer.send(None, body));
    }
}
