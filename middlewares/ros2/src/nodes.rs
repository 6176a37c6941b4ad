//! Nodes of components: each has services of ROS itself as long as a port or service of the component
//! is open here.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_middleware::{Address, PublishError, Publisher, ServiceHandler, ServiceType};
use genom_types::Record;

use crate::lock::lock;
use crate::own_services::OwnServices;
use crate::parameters::{self, Attributes};
use crate::ros::Ros;

/// The nodes that there are, by name with the namespace in front.
#[derive(Default)]
pub(crate) struct Nodes(Mutex<HashMap<String, Node>>);

#[derive(Default)]
struct Node {
    /// Ports and services that are open.
    ends: usize,
    attributes: Attributes,
    /// Number of the component's own services with the name of a parameter service; if there are
    /// any, it has no parameters.
    clashes: usize,
    parameters: Option<OwnServices>,
}

/// A port or a service of a component, which belongs to its node until this is dropped.
pub(crate) struct Part {
    all: Arc<Nodes>,
    node: String,
    is: Is,
}

/// What a port or service is to its node.
enum Is {
    /// One whose name is that of a parameter service.
    Clash,
    /// An attribute that is a parameter, of this name.
    Attribute(String),
    Other,
}

impl Nodes {
    /// Adds an out port to the node of its component.
    pub(crate) fn port(self: &Arc<Self>, ros: &Ros, at: &Address) -> Option<Part> {
        self.add(ros, at, Is::Other, |_| {})
    }

    /// Adds a service, which becomes a parameter if it is a suitable attribute.
    pub(crate) fn service(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        ty: &ServiceType,
        handler: &Arc<dyn ServiceHandler>,
    ) -> Option<Part> {
        if ros.options.parameters && parameters::is_taken_by(&at.name) {
            tracing::info!("{at} is a name of ROS: {} has no parameters", at.instance);
            return self.add(ros, at, Is::Clash, |node| node.clashes += 1);
        }
        let Some(attribute) = parameters::attribute(&at.name, ty, handler) else {
            return self.add(ros, at, Is::Other, |_| {});
        };
        self.add(ros, at, Is::Attribute(at.name.clone()), |node| {
            lock(&node.attributes).insert(at.name.clone(), attribute);
        })
    }

    /// An absolute name belongs to no component.
    fn add(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        is: Is,
        change: impl FnOnce(&mut Node),
    ) -> Option<Part> {
        if at.instance.is_empty() {
            return None;
        }
        let name = ros.names.node(&at.instance);
        let mut all = lock(&self.0);
        let node = all.entry(name.clone()).or_default();
        node.ends += 1;
        change(node);
        let given_up = node.settle(ros, &name, at);
        // Dropping services waits for threads that may be serving them.
        drop(all);
        drop(given_up);
        Some(Part { all: Arc::clone(self), node: name, is })
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut all = lock(&self.all.0);
        let Some(node) = all.get_mut(&self.node) else { return };
        node.ends = node.ends.saturating_sub(1);
        // Its handler may have ends of its own, so that it is dropped without the lock.
        let attribute = match &self.is {
            Is::Attribute(name) => lock(&node.attributes).remove(name),
            Is::Clash => {
                node.clashes = node.clashes.saturating_sub(1);
                None
            }
            Is::Other => None,
        };
        let gone = if node.ends == 0 { all.remove(&self.node) } else { None };
        drop(all);
        drop((attribute, gone));
    }
}

impl Node {
    /// Opens or closes the services as needed. Returns what must be dropped when no lock is held.
    fn settle(&mut self, ros: &Ros, name: &str, at: &Address) -> Option<OwnServices> {
        if self.clashes > 0 || !ros.options.parameters {
            return self.parameters.take();
        }
        if self.parameters.is_none() {
            match parameters::open(ros, name, &self.attributes) {
                Ok(services) => self.parameters = Some(services),
                Err(why) => tracing::warn!("{at}: no parameters: {why}"),
            }
        }
        None
    }
}

/// An out port that belongs to a node. Fields are dropped in order.
pub(crate) struct OfNode {
    pub(crate) port: Box<dyn Publisher>,
    pub(crate) _part: Option<Part>,
}

impl Publisher for OfNode {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.port.publish(value)
    }

    fn publish_message(&mut self, message: &[u8]) -> Option<Result<(), PublishError>> {
        self.port.publish_message(message)
    }

    fn dropped(&self) -> u64 {
        self.port.dropped()
    }
}
