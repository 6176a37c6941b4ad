//! What ROS 2 may do with a daemon beyond the ports and services of its components: be its clock, and
//! load and start components.

use std::sync::Arc;

use axum::Router;
use genom_doors::Own;
use genom_lifecycle::{Managed, serve};
use genom_timekeeper::{Source, follow};
use tokio::runtime::Handle;
use tokio::task::spawn_blocking;

use crate::daemon::Daemon;
use crate::refusal::Refusal;

/// From now on, the clock of the components goes on as `/clock` of ROS 2 says.
pub(crate) async fn follow_clock(daemon: &Arc<Daemon>) -> Result<(), Refusal> {
    let worker = Arc::clone(&daemon.supervisor);
    let opening = spawn_blocking(move || Source::open(&worker.backends));
    let source = opening.await.map_err(Refusal::own)?.map_err(Refusal::own)?;
    follow(source, &daemon.supervisor, &daemon.cells, Handle::current()).map_err(Refusal::own)
}

/// From now on, ROS 2 manages these components, with the rights of `router`.
pub(crate) async fn manage(
    daemon: &Arc<Daemon>,
    managed: Vec<Managed>,
    router: Router,
) -> Result<(), Refusal> {
    if managed.is_empty() {
        return Ok(());
    }
    let (worker, plane, runtime) = (Arc::clone(daemon), Own::new(router), Handle::current());
    let opening = spawn_blocking(move || {
        let supervisor = &worker.supervisor;
        let patience = supervisor.settings.stop_timeout;
        let nodes = serve(managed, &supervisor.backends, &plane, patience, &runtime)?;
        worker.nodes.keep(nodes);
        Ok::<_, genom_lifecycle::NotServed>(())
    });
    opening.await.map_err(Refusal::own)?.map_err(Refusal::own)
}
