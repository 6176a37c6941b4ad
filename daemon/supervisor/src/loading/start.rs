//! Starts a component whose library is open: binds its ports, starts its tasks, and offers its
//! services on middlewares.

use std::sync::Arc;

use genom_host::Component;
use genom_runtime::Options;
use genom_runtime::plan::Plan;

use super::built;
use super::error::LoadError;
use super::standard::StandardServices;
use crate::components::{Build, Guard, Hosted, Starting, prepare};
use crate::supervisor::Supervisor;
use crate::ties::{Bindings, Ties};
use genom_bus::flag::Flag;
use genom_configuration::{BackendNames, terms};

/// Binds the ports, then starts the tasks and waits for their start codels.
pub(super) fn start(
    supervisor: &Arc<Supervisor>,
    name: String,
    mut build: Build,
    plan: Arc<Plan>,
    component: Component,
    before: Option<&Arc<Hosted>>,
) -> Result<Arc<Hosted>, LoadError> {
    let prepared = match build.request.resume.as_deref() {
        None => None,
        Some(wanted) => match prepare(&plan, wanted) {
            Ok(prepared) => Some(prepared),
            Err(why) if wanted.copy.is_some() => {
                tracing::error!(instance = name, "it starts anew: its copy does not fit: {why}");
                None
            }
            Err(source) => return Err(LoadError::Resume { name, source: Box::new(source) }),
        },
    };
    build.request.resume = None;
    let request = build.request.clone();
    let default = || BackendNames::one(supervisor.settings.backend.as_str());
    let backend = request.backend.clone().unwrap_or_else(default);
    let bindings = Bindings::new(backend.clone(), request.ports.clone(), request.qos.clone());
    let (ties, killed) = (Arc::new(Ties::new(bindings)), Flag::new());
    if let Some(before) = before {
        ties.promise(before.open_ports());
    }
    let bound = |source| LoadError::Bind { name: name.clone(), source };
    supervisor.connections.opening().bind(&component, &plan, &name, &ties).map_err(bound)?;
    let services = Arc::new(StandardServices::new(supervisor, &name, &killed));
    let mut options = Options::new(name.as_str(), services);
    options.clock = supervisor.clock.clone();
    options.execution = supervisor.execution.clone();
    options.date = built::date(&build.library);
    options.start_timeout = Some(supervisor.settings.start_timeout);
    let weak = Arc::downgrade(supervisor);
    options.give_up = Some(Arc::new(move || {
        weak.upgrade().is_none_or(|supervisor| supervisor.start_is_given_up())
    }));
    options.activity_limit = supervisor.settings.max_activities;
    options.stuck_after = supervisor.settings.stuck_after;
    for (task, entry) in &request.tasks {
        let refused = |source| LoadError::Override { name: name.clone(), source };
        options.tasks.insert(task.clone(), terms::task_options(entry).map_err(refused)?);
    }
    options.rules = genom_rules::rules(&request, plan.component())
        .map_err(|why| LoadError::Supervision { name: name.clone(), source: Box::new(why) })?;
    let (bus, reactions) = (&supervisor.bus, &supervisor.reactions);
    let done = (reactions, &supervisor.withheld);
    let guard = Guard::new(&name, bus, done, &request.supervision);
    let starting = Starting {
        name: name.clone(),
        build,
        plan,
        ties,
        killed,
        bus: Arc::clone(bus),
        guard,
        recordings: Arc::clone(&supervisor.recordings),
        keep_results: supervisor.settings.keep_results,
        prepared,
        before: before.cloned(),
    };
    let hosted = match Hosted::start(starting, Arc::new(component), options) {
        Ok(hosted) => Arc::new(hosted),
        Err(error) => return Err(LoadError::Start { name, why: error.to_string() }),
    };
    if before.is_some() {
        return Ok(hosted);
    }
    match supervisor.connections.serve_on(&hosted, backend.names()) {
        Ok(served) => hosted.serve_also(served, &backend),
        Err(source) => {
            // It is running already and must stop before its memory is freed.
            if let Err(why) = hosted.stop(supervisor.settings.stop_timeout) {
                tracing::error!(instance = name, "{why}");
            }
            return Err(LoadError::Bind { name, source });
        }
    }
    Ok(hosted)
}
