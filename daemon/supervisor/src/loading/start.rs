//! From an opened library to a component that runs: its ports bound, its tasks started, its
//! services on its middlewares.

use std::path::PathBuf;
use std::sync::Arc;

use genom_host::Component;
use genom_runtime::Options;
use genom_runtime::body::Body;
use genom_runtime::plan::Plan;

use super::built;
use super::error::LoadError;
use crate::daemon::Daemon;
use crate::flag::Flag;
use crate::hosting::{Hosted, Starting};
use crate::wires::Wires;
use crate::wires::bindings::Bindings;
use crate::wiring::requests::SupervisorWiring;
use crate::wiring::{publish, serve};
use genom_configuration::{BackendNames, LoadRequest, terms};

/// Binds the ports, then starts the tasks and waits for their start codels.
pub(super) fn start(
    daemon: &Arc<Daemon>,
    request: &LoadRequest,
    name: String,
    library: PathBuf,
    plan: Arc<Plan>,
    component: Component,
) -> Result<Arc<Hosted>, LoadError> {
    let default = || BackendNames::one(daemon.settings.backend.as_str());
    let backend = request.backend.clone().unwrap_or_else(default);
    let bindings = Bindings::new(backend.clone(), request.ports.clone(), request.qos.clone());
    let (wires, killed) = (Arc::new(Wires::new(bindings)), Flag::new());
    let bound = |source| LoadError::Bind { name: name.clone(), source };
    publish::bind(daemon, &component, &plan, &name, &wires).map_err(bound)?;
    let supervisor = Arc::new(SupervisorWiring::new(daemon, &name, &killed));
    let mut options = Options::new(name.as_str(), supervisor);
    options.clock = daemon.clock.clone();
    options.date = built::date(&library);
    options.start_timeout = Some(daemon.settings.start_timeout);
    let weak = Arc::downgrade(daemon);
    options.give_up =
        Some(Arc::new(move || weak.upgrade().is_none_or(|daemon| daemon.start_is_given_up())));
    options.activity_limit = daemon.settings.max_activities;
    options.stuck_after = daemon.settings.stuck_after;
    for (task, entry) in &request.tasks {
        let refused = |why| LoadError::Override { name: name.clone(), why };
        options.tasks.insert(task.clone(), terms::task_options(entry).map_err(refused)?);
    }
    let starting = Starting {
        name: name.clone(),
        request: request.clone(),
        library,
        plan,
        wires,
        killed,
        bus: Arc::clone(&daemon.bus),
        recordings: Arc::clone(&daemon.recordings),
        keep_results: daemon.settings.keep_results,
    };
    let body: Arc<dyn Body> = Arc::new(component);
    let hosted = match Hosted::start(starting, body, options) {
        Ok(hosted) => Arc::new(hosted),
        Err(error) => return Err(LoadError::Start { name, why: error.to_string() }),
    };
    match serve::serve_on(daemon, &hosted, backend.names()) {
        Ok(served) => hosted.serve_also(served, &backend),
        Err(source) => {
            // It runs already: it must stop before its memory goes.
            if let Err(why) = hosted.stop(daemon.settings.stop_timeout) {
                tracing::error!(instance = name, "{why}");
            }
            return Err(LoadError::Bind { name, source });
        }
    }
    Ok(hosted)
}
