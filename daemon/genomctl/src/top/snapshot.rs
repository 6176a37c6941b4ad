//! The data of the live table, asked of the daemon.

use std::time::Instant;

use genom_drawing::top::{Seen, Snapshot};
use genom_protocol::{PortParameters, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Asks the daemon. A component that is unloaded meanwhile is left out.
pub(crate) async fn take(session: &Session) -> Result<Snapshot, Failure> {
    let mut components = Vec::new();
    for component in session.ask(routes::components()).await?.content.components {
        let name = component.name.as_str();
        let Ok(statistics) = session.ask(routes::statistics(name)).await else { continue };
        let Ok(activities) = session.ask(routes::activities(name)).await else { continue };
        let (tasks, log) = (statistics.content.tasks, activities.content.activities);
        components.push(Seen { component, tasks, log });
    }
    let query = PortParameters { values: Some(false) };
    let ports = session.ask(routes::ports().with(&query)).await?.content.ports;
    let daemon = session.client.target();
    Ok(Snapshot { daemon, components, ports, taken: Instant::now() })
}
