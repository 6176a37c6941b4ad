//! Attributes as ROS parameters of their node.
//!
//! Each instance with suitable attributes has the six parameter services of `rcl_interfaces`, which
//! call the attributes as any client does. No values are stored here: a parameter always has the
//! value that the component has.

mod error;
mod events;
mod gather;
mod node;
mod table;
mod value;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_middleware::{Address, ServiceHandler, ServiceKind, ServiceType};

use crate::lock::lock;
use crate::ros::Ros;

use node::{Attributes, Node, SERVICES};
use table::{Attribute, Way};

/// The parameters of all instances of this daemon, by the instance's path.
#[derive(Default)]
pub(crate) struct Parameters(Mutex<HashMap<String, Instance>>);

#[derive(Default)]
struct Instance {
    attributes: Attributes,
    /// Number of the component's own services with the name of a parameter service; if there are
    /// any, it has no parameters.
    clashes: usize,
    /// The services, while there are attributes.
    node: Option<Arc<Node>>,
}

/// A contribution to an instance's parameters, removed when it is dropped.
pub(crate) struct Part {
    all: Arc<Parameters>,
    instance: String,
    /// Name of the attribute; `None` for a service with the name of a parameter service.
    attribute: Option<String>,
}

impl Parameters {
    /// Makes an attribute a parameter, if it is suitable.
    pub(crate) fn add(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        ty: &ServiceType,
        handler: &Arc<dyn ServiceHandler>,
    ) -> Option<Part> {
        if !ros.options.parameters {
            return None;
        }
        let instance = ros.names.node(&at.instance);
        let clash = SERVICES.iter().any(|service| at.name == service.name);
        let way = Way::of(ty).filter(|_| ty.kind == ServiceKind::Attribute);
        let mut all = lock(&self.0);
        let attribute = match way {
            _ if clash => {
                tracing::info!("{at} is a name of ROS: {} has no parameters", at.instance);
                all.entry(instance.clone()).or_default().clashes += 1;
                None
            }
            Some(way) => {
                let name = at.name.clone();
                let (ty, handler) = (ty.clone(), Arc::clone(handler));
                let attribute = Arc::new(Attribute { name: name.clone(), ty, handler, way });
                let attributes = &all.entry(instance.clone()).or_default().attributes;
                lock(attributes).insert(name.clone(), attribute);
                Some(name)
            }
            None => return None,
        };
        let given_up = all.get_mut(&instance)?.settle(ros, &instance, at);
        // Dropping a node waits for threads that may be serving it.
        drop(all);
        drop(given_up);
        Some(Part { all: Arc::clone(self), instance, attribute })
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut all = lock(&self.all.0);
        let Some(known) = all.get_mut(&self.instance) else { return };
        match &self.attribute {
            Some(name) => _ = lock(&known.attributes).remove(name),
            None => known.clashes = known.clashes.saturating_sub(1),
        }
        let nothing = lock(&known.attributes).is_empty();
        let given_up = if nothing { known.node.take() } else { None };
        if nothing && known.clashes == 0 {
            all.remove(&self.instance);
        }
        drop(all);
        drop(given_up);
    }
}

impl Instance {
    /// Creates or removes the services as needed. Returns what must be dropped when no lock is
    /// held.
    fn settle(&mut self, ros: &Ros, instance: &str, at: &Address) -> Option<Arc<Node>> {
        if self.clashes > 0 || lock(&self.attributes).is_empty() {
            return self.node.take();
        }
        if self.node.is_none() {
            match Node::open(ros, instance, Arc::clone(&self.attributes)) {
                Ok(node) => self.node = Some(node),
                Err(why) => tracing::warn!("{at}: no parameters: {why}"),
            }
        }
        None
    }
}
