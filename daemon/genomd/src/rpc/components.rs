//! Components: list, load, describe, unload.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_description::tools;
use serde_json::{Value, json};

use crate::config::LoadRequest;
use crate::daemon::Daemon;
use crate::hosting::{Hosted, LoadError, UnloadError};
use crate::registry::BackendError;
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;

/// The component of that name, running.
pub(super) fn find(daemon: &Daemon, name: &str) -> Result<Arc<Hosted>, RpcError> {
    let components = daemon.components.all();
    match components.iter().find(|hosted| hosted.name == name) {
        Some(hosted) => Ok(Arc::clone(hosted)),
        None => Err(RpcError::unknown(
            "no_such_component",
            "no component",
            name,
            components.iter().map(|hosted| hosted.name.as_str()),
        )),
    }
}

/// `GET /components`
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Value> {
    let components: Vec<_> = daemon.components.all().iter().map(|hosted| summary(hosted)).collect();
    Json(json!({ "components": components }))
}

/// `GET /components/{component}`
pub(crate) async fn describe(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = find(&daemon, &component)?;
    // The description as every tool shows it, and over it what is this instance's own.
    let mut reply = tools::describe(hosted.specification(), hosted.model());
    if let (Value::Object(reply), Value::Object(own)) = (&mut reply, summary(&hosted)) {
        reply.extend(own);
    }
    Ok(Json(reply))
}

/// `POST /components` with `{library, gen, name, backend}`
pub(crate) async fn load(
    State(daemon): State<Arc<Daemon>>,
    Body(request): Body<LoadRequest>,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    let worker = Arc::clone(&daemon);
    let loaded = tokio::task::spawn_blocking(move || worker.load(&request)).await;
    match loaded {
        Ok(Ok(hosted)) => Ok((StatusCode::CREATED, Json(summary(&hosted)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// `DELETE /components/{component}`
pub(crate) async fn unload(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    find(&daemon, &component)?;
    let worker = Arc::clone(&daemon);
    match tokio::task::spawn_blocking(move || worker.unload(&component)).await {
        Ok(Ok(())) => Ok(Json(json!({"unloaded": true}))),
        Ok(Err(error @ UnloadError::NotThere(_))) => {
            Err(RpcError::conflict("unloading", error.to_string()))
        }
        Ok(Err(error @ UnloadError::Stuck { .. })) => Err(RpcError::internal(error.to_string())),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn summary(hosted: &Hosted) -> Value {
    let bindings = &hosted.wiring.bindings;
    json!({
        "name": hosted.name,
        "component": hosted.model().name,
        "state": "running",
        "backend": bindings.component(),
        "port_backends": bindings.ports(),
        "library": hosted.library,
        "activities": hosted.activities.running(),
    })
}

fn refused(error: &LoadError) -> RpcError {
    let message = error.to_string();
    match error {
        LoadError::Taken(_) => RpcError::conflict("name_taken", message)
            .help("give this instance another name")
            .place("/name"),
        LoadError::Backend(BackendError::Unknown { .. }) => {
            RpcError::bad_input(message).place("/backend")
        }
        LoadError::Locate(_) => {
            RpcError::new(StatusCode::NOT_FOUND, "no_such_library", message).place("/library")
        }
        LoadError::NoSuch { what, typed, .. } => RpcError::bad_input(message).place(format!(
            "/{}/{typed}",
            if *what == "attribute" {
                "attributes"
            } else if *what == "task" {
                "tasks"
            } else {
                "ports"
            }
        )),
        LoadError::Stopping => RpcError::conflict("stopping", message),
        _ => RpcError::new(StatusCode::UNPROCESSABLE_ENTITY, "not_loadable", message)
            .place("/library"),
    }
}
