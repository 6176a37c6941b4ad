//! The whole wiring as one document: dump, plan, apply.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::config::{Config, ConfigError, Deployment, Spot};
use crate::daemon::Daemon;
use crate::deploy::apply::ApplyError;
use crate::deploy::plan::PlanError;
use crate::deploy::{self, Step};
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;

/// Seconds a connection waits for its other side when nothing is said.
const PATIENCE: f64 = 10.0;

/// The longest it may be told to wait.
const LONGEST: Duration = Duration::from_secs(86_400);

/// A deployment to apply.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = DeploymentWanted)]
pub(crate) struct Wanted {
    /// The file's text.
    text: String,
    /// The file's name, for messages and for relative paths in it.
    #[schema(value_type = String)]
    file: PathBuf,
    /// Which daemon of the file this is; by default the name the daemon was started with.
    #[serde(default)]
    daemon: Option<String>,
    /// Only tell what would be done.
    #[serde(default)]
    dry_run: bool,
    /// Seconds each connection may wait for its other side.
    #[serde(default)]
    #[schema(minimum = 0, maximum = 86400)]
    timeout: Option<f64>,
}

/// What runs, as a deployment.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Dumped {
    /// The deployment.
    #[schema(value_type = Object)]
    deployment: Deployment,
    /// The same as the text of a file.
    text: String,
}

/// What was done, or would be.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Applied {
    /// The steps, in order.
    steps: Vec<String>,
    /// Whether they were taken.
    applied: bool,
}

/// Tell what runs, as a deployment file.
#[utoipa::path(
    get,
    path = "/deployment",
    tag = "deployment",
    security(("token" = ["read"])),
    responses((status = 200, body = Dumped), (status = 500))
)]
pub(crate) async fn dump(State(daemon): State<Arc<Daemon>>) -> Result<Json<Dumped>, RpcError> {
    let deployment = deploy::dump::dump(&daemon);
    let text =
        toml::to_string(&deployment).map_err(|error| RpcError::internal(error.to_string()))?;
    Ok(Json(Dumped { deployment, text }))
}

/// Bring the daemon to what a deployment file says, or tell how.
#[utoipa::path(
    post,
    path = "/deployment",
    tag = "deployment",
    security(("token" = ["admin"])),
    request_body = Wanted,
    responses((status = 200, body = Applied), (status = 409), (status = 422))
)]
pub(crate) async fn apply(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<Wanted>,
) -> Result<(StatusCode, Json<Applied>), RpcError> {
    let seconds = wanted.timeout.unwrap_or(PATIENCE);
    let patience = Duration::try_from_secs_f64(seconds).ok().filter(|time| *time <= LONGEST);
    let patience = patience.ok_or_else(|| {
        let message = format!("timeout: {seconds} is not between 0 and {} s", LONGEST.as_secs());
        RpcError::bad_input(message).place("/timeout")
    })?;
    let deployment = read(&daemon, &wanted)?;
    let work = move || {
        let _turn = daemon.deploying();
        let steps = deploy::plan::plan(&daemon, &deployment)
            .map_err(|error| impossible(&error, &wanted))?;
        if !wanted.dry_run {
            deploy::apply::apply(&daemon, &steps, Some(patience))
                .map_err(|error| failed(&error, &wanted))?;
            daemon.declared.keep(&deployment.connection);
        }
        let steps = steps.iter().map(Step::to_string).collect();
        Ok((StatusCode::OK, Json(Applied { steps, applied: !wanted.dry_run })))
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(outcome) => outcome,
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn read(daemon: &Daemon, wanted: &Wanted) -> Result<Deployment, RpcError> {
    let mistake = |error: ConfigError| RpcError::bad_input(error.to_string()).place("/text");
    let mut config = Config::parse(&wanted.file, &wanted.text).map_err(mistake)?;
    config.check(&wanted.file, &wanted.text).map_err(mistake)?;
    config.anchor(&wanted.file);
    let name = wanted.daemon.as_deref().or(daemon.settings.name.as_deref());
    let mut deployment = config.deployment(name);
    // A file that says its own default middleware means it for its components.
    if config.backend != Config::default().backend {
        let default = crate::config::BackendNames::one(config.backend.as_str());
        for component in &mut deployment.component {
            component.backend.get_or_insert_with(|| default.clone());
        }
    }
    Ok(deployment)
}

fn impossible(error: &PlanError, wanted: &Wanted) -> RpcError {
    RpcError::conflict("no_plan", told(&error.place(), wanted, error)).help("nothing was changed")
}

/// The message, with file, line and key before it when they are known.
fn told(place: &Spot, wanted: &Wanted, error: &impl std::fmt::Display) -> String {
    match place.told(&wanted.file, &wanted.text) {
        Some(place) => format!("{place}: {error}"),
        None => error.to_string(),
    }
}

fn failed(error: &ApplyError, wanted: &Wanted) -> RpcError {
    let code = if error.timeout { "timeout" } else { "not_applied" };
    let help = if error.left.is_empty() { "everything is as it was before" } else { "see above" };
    RpcError::conflict(code, told(&error.place, wanted, error)).help(help)
}
