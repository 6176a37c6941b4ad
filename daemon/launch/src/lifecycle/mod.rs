//! Components as managed nodes (ROS 2 design, "Managed nodes", `lifecycle_msgs`).
//!
//! [`take`] takes such components out of a deployment, so that the daemon does not load them at its
//! start. [`manage`] offers the services of their nodes, for as long as the daemon runs: whether the
//! component is loaded or not. `machine` has the states and what leads from one to the next; `node`
//! does that; `messages` has the types.

mod machine;
mod managed;
mod messages;
mod node;

use std::sync::Arc;
use std::time::Duration;

use genom_doors::Own;
use genom_middleware::{Address, Middleware, PortSpec};
use genom_registry::Backends;
use genom_types::Record;
use tokio::runtime::Handle;

pub use managed::{Managed, take};
use messages::Service;
use node::{Events, Node};

use crate::offer::{NotServed, Offered};

/// Offers the lifecycle services of these components. They act through `plane`, and wait at most
/// `patience` for an activity to stop. This may take a while, as it opens the middleware.
///
/// # Errors
/// The middleware cannot be opened, or refuses a service.
pub fn manage(
    managed: Vec<Managed>,
    backends: &Arc<Backends>,
    plane: &Own,
    patience: Duration,
    runtime: &Handle,
) -> Result<Offered, NotServed> {
    let mut offered = Offered::nothing(backends)?;
    offered.speak(backends, &Service::ALL)?;
    for what in managed {
        let name = what.name.clone();
        tracing::info!("{name}: is managed by ROS 2: it is loaded when that configures it");
        let events = events(offered.middleware(), &name)?;
        let node = Arc::new(Node::new(what, plane.clone(), patience, events));
        offered.add(&name, &Service::ALL, &node, runtime)?;
    }
    Ok(offered)
}

fn events(middleware: &dyn Middleware, node: &str) -> Result<Events, NotServed> {
    let ty = messages::event()?;
    let address = Address::new(node, "transition_event");
    let publisher = middleware.publisher(&PortSpec::new(&address, &ty))?;
    Ok(Events { publisher, message: Record::new(&ty) })
}
