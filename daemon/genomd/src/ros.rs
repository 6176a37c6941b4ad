//! What ROS 2 may do with a daemon beyond the ports and services of its components: be its clock, and
//! load and start components.

use std::sync::Arc;

use axum::Router;
use genom_configuration::{ClockKind, Config, ContainerSection};
use genom_doors::Own;
use genom_launch::{Container, Managed, NotServed, Offered};
use genom_registry::Backends;
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
    let patience = daemon.supervisor.settings.stop_timeout;
    offer(daemon, router, move |backends, plane, runtime| {
        genom_launch::manage(managed, backends, plane, patience, runtime)
    })
    .await
}

/// From now on, ROS 2 loads components of this section, with the rights of `router`.
pub(crate) async fn contain(
    daemon: &Arc<Daemon>,
    config: &Config,
    router: Router,
) -> Result<(), Refusal> {
    let section = &config.container;
    if section.components.is_empty() || daemon.own_cell.is_some() {
        return Ok(());
    }
    let settings = &daemon.supervisor.settings;
    let ContainerSection { components, node, backend, most } = section.clone();
    let (path, include) = (settings.path.clone(), settings.include.clone());
    let simulated = config.clock == ClockKind::Ros;
    let container = Container { node, components, backend, most, path, simulated, include };
    offer(daemon, router, move |backends, plane, runtime| {
        genom_launch::contain(container, backends, plane, runtime)
    })
    .await
}

/// Opens what is offered, where waiting disturbs nobody, and keeps it as long as the daemon runs.
async fn offer(
    daemon: &Arc<Daemon>,
    router: Router,
    open: impl FnOnce(&Arc<Backends>, &Own, &Handle) -> Result<Offered, NotServed> + Send + 'static,
) -> Result<(), Refusal> {
    let (worker, plane, runtime) = (Arc::clone(daemon), Own::new(router), Handle::current());
    let opening = spawn_blocking(move || {
        worker.offers.keep(open(&worker.supervisor.backends, &plane, &runtime)?);
        Ok::<_, NotServed>(())
    });
    opening.await.map_err(Refusal::own)?.map_err(Refusal::own)
}
