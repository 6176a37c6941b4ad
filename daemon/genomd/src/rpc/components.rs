//! Components: list, load, describe, unload.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_description_tools as tools;
use genom_runtime::{RunningCodel, seconds};
use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use crate::config::{BackendNames, LoadRequest};
use crate::daemon::Daemon;
use crate::hosting::{Hosted, Spin, UnloadError};
use crate::loading::{self, LoadError};
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

/// Components, in the order they were loaded.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Components {
    components: Vec<Summary>,
    /// Names of those that are being loaded, or are to be at the daemon's start; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    loading: Vec<String>,
    /// What is left of components that did not stop in time; absent when nothing is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    left_behind: Vec<Left>,
}

/// What is left of a component: threads in codels that do not return. Its name is free.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = LeftBehind)]
pub(crate) struct Left {
    /// The name it had.
    was: String,
    /// Name in the description.
    component: String,
    /// `left behind: stuck in CODEL for 12 s`.
    state: String,
}

/// A component that runs.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Component)]
pub(crate) struct Summary {
    /// Instance name.
    name: String,
    /// Name in the description.
    component: String,
    /// `running`, `damaged` (its codels wrote past the memory they were given),
    /// `stuck in CODEL for 12 s`, or `spins in CODEL for 12 s`.
    state: String,
    /// Codels that have not returned for so long that they count as stuck; absent without any.
    #[schema(value_type = Vec<Object>)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stuck: Vec<RunningCodel>,
    /// Tasks that keep a processor and do not pause; absent without any.
    #[schema(value_type = Vec<Object>)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    spins: Vec<Spin>,
    /// Middlewares of its services, and of ports that have no others.
    backend: BackendNames,
    /// Middlewares of ports that have others.
    port_backends: BTreeMap<String, BackendNames>,
    /// File of the library.
    #[schema(value_type = String)]
    library: PathBuf,
    /// Activities that run.
    activities: usize,
    /// Services of others that its codels call, by name: what can be connected to one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    remotes: Vec<String>,
}

/// A component is gone.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Unloaded {
    unloaded: bool,
}

/// List the components that run.
#[utoipa::path(
    get,
    path = "/components",
    tag = "components",
    security(("token" = ["read"])),
    responses((status = 200, body = Components))
)]
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Components> {
    let components = daemon.components.all().iter().map(|hosted| summary(hosted)).collect();
    let left_behind = daemon.components.left_behind().into_iter().map(|remnant| {
        let longest = remnant.codels.iter().max_by_key(|codel| codel.for_ns);
        let state = longest.map_or("left behind: about to end".to_owned(), |codel| {
            format!("left behind: stuck in {} for {}", codel.codel, seconds(codel.for_ns))
        });
        Left { was: remnant.was, component: remnant.component, state }
    });
    let loading = loading(&daemon);
    Json(Components { components, loading, left_behind: left_behind.collect() })
}

fn loading(daemon: &Daemon) -> Vec<String> {
    let (mut names, mut later) = (daemon.components.loading(), daemon.startup.to_load());
    if !names.is_empty() && !later.is_empty() {
        // The first of them is among those that are being loaded, under the name it will have.
        later.remove(0);
    }
    names.append(&mut later);
    names
}

/// Describe a component: what it is, and all its description says.
///
/// `served` of a service names the middlewares that it is offered on (`[services]` of the daemon's
/// configuration). Beside the members below: `tasks`, `ports`, `services`, `events`, `throws`, `doc`
/// and more, as `genomctl describe` prints them; `uses` has what it prints of `remotes`.
#[utoipa::path(
    get,
    path = "/components/{component}",
    tag = "components",
    security(("token" = ["read"])),
    responses((status = 200, body = Summary), (status = 404))
)]
pub(crate) async fn describe(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = find(&daemon, &component)?;
    // The description as every tool shows it, and over it what is this instance's own.
    let mut reply = tools::describe(hosted.specification(), hosted.model());
    for (index, service) in reply["services"].as_array_mut().into_iter().flatten().enumerate() {
        service["served"] = hosted.served_on(index).into();
    }
    // There by name only: what each calls stands here.
    reply["uses"] = reply["remotes"].take();
    let own = serde_json::to_value(summary(&hosted));
    if let (Value::Object(reply), Ok(Value::Object(own))) = (&mut reply, own) {
        reply.extend(own);
    }
    Ok(Json(reply))
}

/// Tell the types of a component as JSON Schemas: inputs and outputs of services, ports.
///
/// Docs and defaults are those of the description. `$defs` holds the types that are named.
#[utoipa::path(
    get,
    path = "/components/{component}/schema",
    tag = "components",
    security(("token" = ["read"])),
    responses((status = 200, body = Object), (status = 404))
)]
pub(crate) async fn schema(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = find(&daemon, &component)?;
    Ok(Json(tools::schema(hosted.specification(), hosted.model())))
}

/// Load a component and start its tasks.
#[utoipa::path(
    post,
    path = "/components",
    tag = "components",
    security(("token" = ["admin"])),
    request_body = LoadRequest,
    responses((status = 201, body = Summary), (status = 404), (status = 409), (status = 422))
)]
pub(crate) async fn load(
    State(daemon): State<Arc<Daemon>>,
    Body(request): Body<LoadRequest>,
) -> Result<(StatusCode, Json<Summary>), RpcError> {
    let worker = Arc::clone(&daemon);
    let loaded = tokio::task::spawn_blocking(move || loading::load(&worker, &request)).await;
    match loaded {
        Ok(Ok(hosted)) => Ok((StatusCode::CREATED, Json(summary(&hosted)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// Stop a component's activities and tasks, and close its library.
#[utoipa::path(
    delete,
    path = "/components/{component}",
    tag = "components",
    security(("token" = ["admin"])),
    responses((status = 200, body = Unloaded), (status = 404), (status = 409), (status = 503))
)]
pub(crate) async fn unload(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Unloaded>, RpcError> {
    find(&daemon, &component)?;
    let worker = Arc::clone(&daemon);
    match tokio::task::spawn_blocking(move || worker.unload(&component)).await {
        Ok(Ok(())) => Ok(Json(Unloaded { unloaded: true })),
        Ok(Err(error @ UnloadError::NotThere(_))) => {
            Err(RpcError::conflict("unloading", error.to_string()))
        }
        Ok(Err(error @ UnloadError::Stuck { .. })) => {
            let status = StatusCode::SERVICE_UNAVAILABLE;
            Err(RpcError::new(status, "left_behind", error.to_string())
                .help("`genomctl list` tells until it has ended; restart genomd to be rid of it"))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn summary(hosted: &Hosted) -> Summary {
    let bindings = &hosted.wires.bindings;
    let spins = hosted.spins();
    let spinning = || {
        let longest = spins.iter().max_by_key(|spin| spin.unpaused.for_ns)?;
        let (codel, time) = (&longest.unpaused.codel, seconds(longest.unpaused.for_ns));
        Some(format!("spins in {codel} for {time}"))
    };
    Summary {
        name: hosted.name.clone(),
        component: hosted.model().name.clone(),
        state: match hosted.damage() {
            Some(_) => "damaged".to_owned(),
            None => hosted.stuck_in().or_else(spinning).unwrap_or_else(|| "running".to_owned()),
        },
        spins,
        stuck: hosted.stuck(),
        backend: bindings.component(),
        port_backends: bindings.ports(),
        library: hosted.library.clone(),
        activities: hosted.activities.running(),
        remotes: hosted.model().remotes.iter().map(|remote| remote.name.clone()).collect(),
    }
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
        LoadError::Qos { port, .. } => {
            RpcError::bad_input(message).place(format!("/qos/ports/{port}"))
        }
        LoadError::Stopping => RpcError::conflict("stopping", message),
        _ => RpcError::new(StatusCode::UNPROCESSABLE_ENTITY, "not_loadable", message)
            .place("/library"),
    }
}
