//! Attributes as ROS parameters of their node.
//!
//! Each instance with an attribute that fits has the six parameter services of `rcl_interfaces`;
//! they ask the attributes, as any caller does. Nothing is kept here: a parameter has the value
//! that the component has.

mod gather;
mod node;
mod table;
mod value;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_middleware::{Address, ServiceHandler, ServiceKind, ServiceType};

use crate::backend::Core;
use crate::server::lock;

use node::{Attributes, Node, SERVICES};
use table::{Attribute, Way};

/// The parameters of all instances of this daemon, by the path of the instance.
#[derive(Default)]
pub(crate) struct Parameters(Mutex<HashMap<String, Instance>>);

#[derive(Default)]
struct Instance {
    attributes: Attributes,
    /// Its own services that go by a name of these services: then it has no parameters.
    clashes: usize,
    /// The services, while there are attributes.
    node: Option<Arc<Node>>,
}

/// A part of an instance's parameters, to be taken away again.
pub(crate) enum Part {
    Attribute { instance: String, name: String },
    Clash { instance: String },
}

impl Core {
    fn instance(&self, at: &Address) -> String {
        let path = self.path(&Address::new(at.instance.clone(), "x"));
        path.strip_suffix("/x").unwrap_or(&path).to_owned()
    }

    /// Makes an attribute a parameter, if it fits.
    pub(crate) fn add_parameter(
        &self,
        at: &Address,
        ty: &ServiceType,
        handler: &Arc<dyn ServiceHandler>,
    ) -> Option<Part> {
        if !self.options.parameters {
            return None;
        }
        let instance = self.instance(at);
        let clash = SERVICES.iter().any(|service| at.name == service.name);
        let way = Way::of(ty).filter(|_| ty.kind == ServiceKind::Attribute);
        let mut all = lock(&self.services.parameters.0);
        let part = match way {
            _ if clash => {
                tracing::info!("{at} is a name of ROS: {} has no parameters", at.instance);
                all.entry(instance.clone()).or_default().clashes += 1;
                Part::Clash { instance: instance.clone() }
            }
            Some(way) => {
                let name = at.name.clone();
                let (ty, handler) = (ty.clone(), Arc::clone(handler));
                let attribute = Arc::new(Attribute { name: name.clone(), ty, handler, way });
                let attributes = &all.entry(instance.clone()).or_default().attributes;
                lock(attributes).insert(name.clone(), attribute);
                Part::Attribute { instance: instance.clone(), name }
            }
            None => return None,
        };
        let given_up = self.settle(&instance, at, all.get_mut(&instance)?);
        // Its end waits for threads that may be at work for it.
        drop(all);
        drop(given_up);
        Some(part)
    }

    /// The attribute is not served any more.
    pub(crate) fn remove_parameter(&self, part: &Part) {
        let mut all = lock(&self.services.parameters.0);
        let (Part::Attribute { instance, .. } | Part::Clash { instance }) = part;
        let Some(known) = all.get_mut(instance) else { return };
        match part {
            Part::Attribute { name, .. } => _ = lock(&known.attributes).remove(name),
            Part::Clash { .. } => known.clashes = known.clashes.saturating_sub(1),
        }
        let nothing = lock(&known.attributes).is_empty();
        let given_up = if nothing { known.node.take() } else { None };
        if nothing && known.clashes == 0 {
            all.remove(instance);
        }
        drop(all);
        drop(given_up);
    }

    /// Has the services there if they should be; what is to be dropped once no lock is held.
    fn settle(&self, instance: &str, at: &Address, known: &mut Instance) -> Option<Arc<Node>> {
        if known.clashes > 0 || lock(&known.attributes).is_empty() {
            return known.node.take();
        }
        if known.node.is_none() {
            match Node::open(self, instance, at, Arc::clone(&known.attributes)) {
                Ok(node) => known.node = Some(node),
                Err(why) => tracing::warn!("{at}: no parameters: {why}"),
            }
        }
        None
    }
}
