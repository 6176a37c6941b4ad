//! Deployments: dump, plan, apply.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::{Extension, Json};
use genom_cells::{Cells, DeployError, isolate_scripts};
use genom_configuration::{Config, ConfigError, Deployment, Right, Spot};
use genom_doors::{Body, Holder, RpcError};
use genom_protocol::{Applied, Code, DeploymentRequest, Dumped, RunningDeployment, TakenBack};
use genom_supervisor::Supervisor;
use genom_supervisor::deploy::{ApplyError, Contradiction, Step, StepError, Steps};
use genom_supervisor::loading::check_reactions;
use tokio::task::block_in_place;

use crate::daemon::Daemon;
use crate::rpc::cells;
use genom_cells::own as own_cell;

/// Default of `timeout`, in seconds.
const PATIENCE: f64 = 10.0;

/// Maximum of `timeout`.
const LONGEST: Duration = Duration::from_secs(86_400);

/// Get the running system as a deployment file.
///
/// Options of middlewares are included for clients with the right `admin`.
#[utoipa::path(
    get,
    path = "/deployment",
    tag = "deployment",
    responses((status = 200, body = Dumped), (status = 500))
)]
pub(crate) async fn dump(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Extension(holder): Extension<Holder>,
) -> Result<Json<Dumped>, RpcError> {
    let backends = match holder.may(Right::Admin, "") {
        // TOML becomes JSON.
        Ok(()) => serde_json::to_value(&supervisor.settings.backends)
            .and_then(serde_json::from_value)
            .map_err(|error| RpcError::internal(error.to_string()))?,
        Err(_) => BTreeMap::new(),
    };
    let (backend, runs) = (supervisor.settings.backend.clone(), supervisor.dump());
    let mut deployment = RunningDeployment { backend, backends, runs };
    cells.join_deployment(&mut deployment).await;
    let text =
        toml::to_string(&deployment).map_err(|error| RpcError::internal(error.to_string()))?;
    Ok(Json(Dumped { deployment, text }))
}

/// Apply a deployment file, or list the steps this would take.
#[utoipa::path(
    post,
    path = "/deployment",
    tag = "deployment",
    request_body = DeploymentRequest,
    responses((status = 200, body = Applied), (status = 409), (status = 422))
)]
pub(crate) async fn apply(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<DeploymentRequest>,
) -> Result<Json<Applied>, RpcError> {
    let seconds = wanted.timeout.unwrap_or(PATIENCE);
    let patience = Duration::try_from_secs_f64(seconds).ok().filter(|time| *time <= LONGEST);
    let patience = patience.ok_or_else(|| {
        let message = format!("timeout: {seconds} is not between 0 and {} s", LONGEST.as_secs());
        RpcError::bad_input(message).place("/timeout")
    })?;
    let supervisor = Arc::clone(&daemon.supervisor);
    let mut whole = read(daemon.name.as_deref(), &wanted)?;
    // In a cell, too, which so finds its part.
    isolate_scripts(&mut whole.component, &supervisor.settings.path);
    // What names no component of any process is a mistake, which the daemon itself reports.
    let here = |name: &str| match &daemon.own_cell {
        Some(_) => supervisor.components.get(name).is_some(),
        None => daemon.cells.of(name).is_none(),
    };
    let mut deployment = whole.part(wanted.cell.as_deref(), here);
    if daemon.own_cell.is_some() {
        deployment.component.iter_mut().for_each(own_cell::share);
    }
    let front = daemon.own_cell.is_none();
    if front {
        let runs = |name: &str| {
            supervisor.components.get(name).is_some() || daemon.cells.of(name).is_some()
        };
        let checked = block_in_place(|| check_reactions(&supervisor.settings, &whole, runs));
        checked.map_err(|(place, error)| {
            RpcError::conflict(Code::NoPlan, placed(&place, &wanted, &error))
                .help("nothing was changed")
        })?;
    }
    let request = wanted.clone();
    let work = move || {
        let _turn = supervisor.deploying();
        let Steps { to_take: steps, beside } = supervisor
            .steps_to(&deployment, wanted.prune)
            .map_err(|error| impossible(&error, &wanted))?;
        let mut done = None;
        if !wanted.dry_run {
            let taken = supervisor.apply(&steps, Some(patience));
            done = Some(taken.map_err(|error| failed(&error, &wanted))?);
            supervisor.connections.declare(&deployment.connection);
        }
        let steps = steps.iter().map(Step::to_string).collect();
        let beside = if wanted.prune { Vec::new() } else { beside };
        let beside = beside.iter().map(|step| match step {
            Step::Unload(name) => format!("component {name}"),
            Step::Disconnect(entry) => format!("connection {entry}"),
            other => other.to_string(),
        });
        let (applied, beside) = (!wanted.dry_run, beside.collect());
        Ok((Applied { steps, applied, beside }, done))
    };
    // A cell has no cells of its own.
    let whole = if front { whole } else { Deployment::default() };
    let asked = request.clone();
    // Whoever asked may go away meanwhile: it is then applied as a whole, or undone, all the same.
    let deploying =
        async move { daemon.cells.deploy(&daemon.supervisor, &whole, &asked, work).await };
    let deployed = tokio::spawn(deploying).await;
    match deployed.unwrap_or_else(|error| Err(DeployError::Thread(error))) {
        Ok(applied) => Ok(Json(applied)),
        Err(DeployError::Load(component, error)) => {
            let place = Spot::component(&component).key(["cell"]);
            Err(RpcError::conflict(Code::NotApplied, placed(&place, &request, &error)))
        }
        Err(DeployError::Own(error)) => Err(error),
        Err(DeployError::Cell { why, left }) => {
            let all = format!("all is as it was, but for: {}", left.join(", "));
            Err(if left.is_empty() { cells::refused(why) } else { cells::refused(why).help(all) })
        }
        Err(DeployError::Thread(error)) => Err(RpcError::internal(error.to_string())),
    }
}

/// Undo what the last deployment did, in all processes.
#[utoipa::path(
    post,
    path = "/deployment/take_back",
    tag = "deployment",
    responses((status = 200, body = TakenBack), (status = 409))
)]
pub(crate) async fn take_back(
    State(daemon): State<Arc<Daemon>>,
) -> Result<Json<TakenBack>, RpcError> {
    let left = daemon.cells.take_back(&daemon.supervisor).await;
    let nothing = || RpcError::conflict(Code::NotApplied, "no deployment is known to undo");
    left.map(|left| Json(TakenBack { left })).ok_or_else(nothing)
}

/// What is asked for; of several daemons in the file the one that is named, else `own`.
fn read(own: Option<&str>, wanted: &DeploymentRequest) -> Result<Deployment, RpcError> {
    let mistake = |error: ConfigError| RpcError::bad_input(error.to_string()).place("/text");
    let mut config = Config::parse(&wanted.file, &wanted.text).map_err(mistake)?;
    config.check(&wanted.file, &wanted.text).map_err(mistake)?;
    config.anchor(&wanted.file);
    let name = wanted.daemon.as_deref().or(own);
    config.deployment_elsewhere(name).map_err(|why| {
        RpcError::bad_input(format!("{}: {why}", wanted.file.display())).place("/daemon")
    })
}

fn impossible(error: &Contradiction, wanted: &DeploymentRequest) -> RpcError {
    RpcError::conflict(Code::NoPlan, placed(&error.place(), wanted, error))
        .help("nothing was changed")
}

/// The message, preceded by file, line and key if these are known.
fn placed(place: &Spot, wanted: &DeploymentRequest, error: &impl std::fmt::Display) -> String {
    match place.told(&wanted.file, &wanted.text) {
        Some(place) => format!("{place}: {error}"),
        None => error.to_string(),
    }
}

fn failed(error: &ApplyError, wanted: &DeploymentRequest) -> RpcError {
    let late = matches!(*error.why, StepError::Absent { .. });
    let code = if late { Code::Timeout } else { Code::NotApplied };
    let help = if error.left.is_empty() { "everything is as it was before" } else { "see above" };
    RpcError::conflict(code, placed(&error.place, wanted, error)).help(help)
}
