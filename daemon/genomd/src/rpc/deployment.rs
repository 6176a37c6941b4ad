//! The whole wiring as one document: dump, plan, apply.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::config::{Config, ConfigError, Deployment};
use crate::daemon::Daemon;
use crate::deploy::apply::ApplyError;
use crate::deploy::plan::PlanError;
use crate::deploy::{self, Step};
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;

/// Seconds a connection waits for its other side when nothing is said.
const PATIENCE: f64 = 10.0;

/// Body of `POST /deployment`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// The file's text.
    text: String,
    /// The file's name, for messages and for relative paths in it.
    file: PathBuf,
    /// Which daemon of the file this is; by default the name the daemon was started with.
    #[serde(default)]
    daemon: Option<String>,
    /// Only tell what would be done.
    #[serde(default)]
    dry_run: bool,
    /// Seconds each connection may wait for its other side.
    #[serde(default)]
    timeout: Option<f64>,
}

/// `GET /deployment`: what runs, as a file.
pub(crate) async fn dump(State(daemon): State<Arc<Daemon>>) -> Result<Json<Value>, RpcError> {
    let deployment = deploy::dump::dump(&daemon);
    let text =
        toml::to_string(&deployment).map_err(|error| RpcError::internal(error.to_string()))?;
    Ok(Json(json!({"deployment": deployment, "text": text})))
}

/// `POST /deployment`: plans, and unless `dry_run` applies.
pub(crate) async fn apply(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<Wanted>,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    let seconds = wanted.timeout.unwrap_or(PATIENCE);
    let patience = Duration::try_from_secs_f64(seconds).map_err(|_| {
        RpcError::bad_input(format!("timeout: {seconds} is no time")).place("/timeout")
    })?;
    let deployment = read(&daemon, &wanted)?;
    let work = move || {
        let _turn = daemon.deploying();
        let steps = deploy::plan::plan(&daemon, &deployment).map_err(|error| impossible(&error))?;
        if !wanted.dry_run {
            deploy::apply::apply(&daemon, &steps, Some(patience))
                .map_err(|error| failed(&error))?;
            daemon.declared.keep(&deployment.connection);
        }
        let told: Vec<String> = steps.iter().map(Step::to_string).collect();
        Ok((StatusCode::OK, Json(json!({"steps": told, "applied": !wanted.dry_run}))))
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
    let mut deployment = Deployment::of(&config, name);
    // A file that says its own default middleware means it for its components.
    if config.backend != Config::default().backend {
        let default = crate::config::BackendNames::one(config.backend.as_str());
        for component in &mut deployment.component {
            component.backend.get_or_insert_with(|| default.clone());
        }
    }
    Ok(deployment)
}

fn impossible(error: &PlanError) -> RpcError {
    RpcError::conflict("no_plan", error.to_string()).help("nothing was changed")
}

fn failed(error: &ApplyError) -> RpcError {
    let code = if error.timeout { "timeout" } else { "not_applied" };
    let help = if error.left.is_empty() { "everything is as it was before" } else { "see above" };
    RpcError::conflict(code, error.to_string()).help(help)
}
