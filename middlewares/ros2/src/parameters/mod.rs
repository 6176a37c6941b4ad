//! Attributes as ROS parameters of their node, and the parameter `use_sim_time` that every node has.
//!
//! Six services of `rcl_interfaces` call the attributes as any client does. No values are stored
//! here: a parameter always has the value that the component has.

mod clock;
mod error;
mod events;
mod gather;
mod requests;
mod table;
mod value;

use std::sync::Arc;

use genom_middleware::{ServiceHandler, ServiceKind, ServiceType};

use crate::names::TypeName;
use crate::own_services::{OwnService, OwnServices};
use crate::rmw::EndError;
use crate::ros::Ros;

use events::Events;
use requests::{Parameters, SERVICES};
use table::{Attribute, Way};

pub(crate) use table::Attributes;

/// The services of a node with these attributes. `node` has the namespace in front.
pub(crate) fn open(
    ros: &Ros,
    node: &str,
    attributes: &Attributes,
) -> Result<OwnServices, EndError> {
    let events = Events::open(ros, node)?;
    let entities = events.entities();
    let attributes = Arc::clone(attributes);
    let state = Arc::new(Parameters { events, attributes, simulated: ros.is_simulated() });
    OwnServices::open(ros, node, &SERVICES, &state, entities)
}

/// Whether one of these services has this name.
pub(crate) fn is_taken_by(name: &str) -> bool {
    SERVICES.iter().any(|service| service.name == name)
}

/// The types of these services, and of what they tell.
pub(crate) fn types() -> impl Iterator<Item = TypeName> {
    SERVICES.iter().map(OwnService::type_name).chain([events::type_name()])
}

/// The attribute that a service is to a parameter, if it is one.
pub(crate) fn attribute(
    name: &str,
    ty: &ServiceType,
    handler: &Arc<dyn ServiceHandler>,
) -> Option<Arc<Attribute>> {
    let way = Way::of(ty).filter(|_| ty.kind == ServiceKind::Attribute)?;
    let (name, ty, handler) = (name.to_owned(), ty.clone(), Arc::clone(handler));
    Some(Arc::new(Attribute { name, ty, handler, way }))
}
