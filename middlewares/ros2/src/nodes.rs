//! Nodes of components: each has services of ROS itself as long as a port or service of the component
//! is open here.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_middleware::{
    Address, PublishError, Publisher, ServiceHandler, ServiceKind, ServiceType,
};
use genom_types::Record;

use crate::descriptions::{self, Types};
use crate::lock::lock;
use crate::names::TypeName;
use crate::own_services::OwnServices;
use crate::parameters::{self, Attributes};
use crate::rmw::EndError;
use crate::ros::Ros;
use crate::used::{Parts, Used};

/// The nodes that there are, by name with the namespace in front.
#[derive(Default)]
pub(crate) struct Nodes(Mutex<HashMap<String, Node>>);

#[derive(Default)]
struct Node {
    /// Ports and services that are open.
    ends: usize,
    attributes: Attributes,
    types: Types,
    parameters: Group,
    descriptions: Group,
}

/// Services of ROS itself that a node has together.
#[derive(Default)]
struct Group {
    /// Number of the component's own services that have the name of one of them; if there are any,
    /// these are not there.
    clashes: usize,
    services: Option<OwnServices>,
}

/// Which services of ROS itself.
#[derive(Clone, Copy)]
enum Which {
    Parameters,
    Descriptions,
}

impl Which {
    /// Those that have a service of this name.
    fn has(name: &str) -> Option<Self> {
        if parameters::is_taken_by(name) {
            Some(Self::Parameters)
        } else {
            descriptions::is_taken_by(name).then_some(Self::Descriptions)
        }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Parameters => "parameters",
            Self::Descriptions => "descriptions of types",
        }
    }
}

/// A port or a service of a component, which belongs to its node until this is dropped.
pub(crate) struct Part {
    all: Arc<Nodes>,
    node: String,
    is: Is,
    /// Hashes of the types that it uses.
    types: Vec<String>,
}

/// What a port or service is to its node.
enum Is {
    /// One whose name is that of a service of ROS itself.
    Clash(Which),
    /// An attribute that is a parameter, of this name.
    Attribute(String),
    Other,
}

impl Nodes {
    /// Adds an out port to the node of its component.
    pub(crate) fn port(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        used: Option<Arc<Used>>,
    ) -> Option<Part> {
        self.add(ros, at, Is::Other, used.into_iter().collect(), |_| {})
    }

    /// Adds a service, which becomes a parameter if it is a suitable attribute.
    pub(crate) fn service(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        ty: &ServiceType,
        handler: &Arc<dyn ServiceHandler>,
        parts: &Parts,
    ) -> Option<Part> {
        let mut used: Vec<_> = parts.all().cloned().collect();
        if ty.kind == ServiceKind::Activity {
            for (folder, name) in [("srv", "CancelGoal"), ("msg", "GoalStatusArray")] {
                used.extend(ros.masquerades.of_ros(&TypeName::new("action_msgs", folder, name)));
            }
        }
        if let Some(which) = Which::has(&at.name) {
            let what = which.what();
            tracing::info!("{at} is a name of ROS: {} has no {what}", at.instance);
            return self.add(ros, at, Is::Clash(which), used, |node| node.of(which).clashes += 1);
        }
        let Some(attribute) = parameters::attribute(&at.name, ty, handler) else {
            return self.add(ros, at, Is::Other, used, |_| {});
        };
        self.add(ros, at, Is::Attribute(at.name.clone()), used, |node| {
            lock(&node.attributes).insert(at.name.clone(), attribute);
        })
    }

    /// An absolute name belongs to no component.
    fn add(
        self: &Arc<Self>,
        ros: &Ros,
        at: &Address,
        is: Is,
        used: Vec<Arc<Used>>,
        change: impl FnOnce(&mut Node),
    ) -> Option<Part> {
        if at.instance.is_empty() {
            return None;
        }
        let name = ros.names.node(&at.instance);
        let types = used.iter().map(|used| used.hash.clone()).collect();
        let mut all = lock(&self.0);
        let node = all.entry(name.clone()).or_default();
        if node.ends == 0 {
            node.uses(own_types(ros));
        }
        node.ends += 1;
        node.uses(used);
        change(node);
        let given_up = node.settle(ros, &name, at);
        // Dropping services waits for threads that may be serving them.
        drop(all);
        drop(given_up);
        Some(Part { all: Arc::clone(self), node: name, is, types })
    }
}

/// Types of what every node has.
fn own_types(ros: &Ros) -> Vec<Arc<Used>> {
    let names = parameters::types().chain(descriptions::types());
    names.filter_map(|name| ros.masquerades.of_ros(&name)).collect()
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut all = lock(&self.all.0);
        let Some(node) = all.get_mut(&self.node) else { return };
        node.ends = node.ends.saturating_sub(1);
        // Its handler may have ends of its own, so that it is dropped without the lock.
        let attribute = match &self.is {
            Is::Attribute(name) => lock(&node.attributes).remove(name),
            Is::Clash(which) => {
                let group = node.of(*which);
                group.clashes = group.clashes.saturating_sub(1);
                None
            }
            Is::Other => None,
        };
        node.no_longer_uses(&self.types);
        let gone = if node.ends == 0 { all.remove(&self.node) } else { None };
        drop(all);
        drop((attribute, gone));
    }
}

impl Node {
    fn of(&mut self, which: Which) -> &mut Group {
        match which {
            Which::Parameters => &mut self.parameters,
            Which::Descriptions => &mut self.descriptions,
        }
    }

    fn uses(&self, used: Vec<Arc<Used>>) {
        let mut types = lock(&self.types);
        for used in used {
            types.entry(used.hash.clone()).or_insert((used, 0)).1 += 1;
        }
    }

    fn no_longer_uses(&self, hashes: &[String]) {
        let mut types = lock(&self.types);
        for hash in hashes {
            let Some((_, users)) = types.get_mut(hash) else { continue };
            *users -= 1;
            if *users == 0 {
                types.remove(hash);
            }
        }
    }

    /// Opens or closes the services as needed. Returns what must be dropped when no lock is held.
    fn settle(&mut self, ros: &Ros, name: &str, at: &Address) -> [Option<OwnServices>; 2] {
        let Self { attributes, types, parameters, descriptions, .. } = self;
        let (options, opened) = (&ros.options, |which: Which, services| match services {
            Ok(services) => Some(services),
            Err(why) => {
                let why: EndError = why;
                tracing::warn!("{at}: no {}: {why}", which.what());
                None
            }
        });
        [
            parameters.settle(options.parameters, || {
                opened(Which::Parameters, parameters::open(ros, name, attributes))
            }),
            descriptions.settle(options.type_descriptions, || {
                opened(Which::Descriptions, descriptions::open(ros, name, types))
            }),
        ]
    }
}

impl Group {
    fn settle(
        &mut self,
        wanted: bool,
        open: impl FnOnce() -> Option<OwnServices>,
    ) -> Option<OwnServices> {
        if self.clashes > 0 || !wanted {
            return self.services.take();
        }
        if self.services.is_none() {
            self.services = open();
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
