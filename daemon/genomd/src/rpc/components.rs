//! Components: list, load, describe, unload.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_cells::{Cells, isolate_scripts};
use genom_description_tools as tools;
use genom_doors::{Body, RpcError};
use genom_protocol::{
    Code, Component, ComponentReload, Components, Description, LeftBehind, LoadRequest,
    ReloadRequest, Unloaded,
};
use genom_registry::BackendError;
use genom_runtime::{NoRest, seconds};
use genom_supervisor::Supervisor;
use genom_supervisor::components::{Hosted, UnloadError};
use genom_supervisor::loading::LoadError;
use genom_supervisor::reloading::ReloadError;
pub(super) use genom_views::find;
use genom_views::held_up;
use serde_json::Value;

use crate::daemon::Daemon;
use crate::rpc::{cells, codels};
use genom_cells::own as own_cell;
use genom_supervisor::bus::startup::Startup;

/// List the running components.
#[utoipa::path(
    get,
    path = "/components",
    tag = "components",
    responses((status = 200, body = Components))
)]
pub(crate) async fn list(
    State(supervisor): State<Arc<Supervisor>>,
    State(startup): State<Arc<Startup>>,
    State(cells): State<Arc<Cells>>,
) -> Json<Components> {
    let components = supervisor.components.all().iter().map(|hosted| summary(hosted)).collect();
    let left_behind = supervisor.components.left_behind().into_iter().map(|remnant| {
        let longest = remnant.codels.iter().max_by_key(|codel| codel.for_ns);
        let state = longest.map_or("left behind: about to end".to_owned(), |codel| {
            format!("left behind: stuck in {} for {}", codel.codel, seconds(codel.for_ns))
        });
        LeftBehind { was: remnant.was, component: remnant.component, state }
    });
    let loading = loading(supervisor.components.loading(), startup.to_load());
    let mut all = Components { components, loading, left_behind: left_behind.collect() };
    cells.join_components(&mut all).await;
    Json(all)
}

/// Those that are being loaded, and then those of the start that are still to be.
fn loading(mut names: Vec<String>, mut later: Vec<String>) -> Vec<String> {
    if !names.is_empty() && !later.is_empty() {
        // The first of these is being loaded, and is listed already under its final name.
        later.remove(0);
    }
    names.append(&mut later);
    names
}

/// Describe a component: its state, and the content of its description.
///
/// `served` of a service lists the middlewares that it is offered on (`[services]` of the daemon's
/// configuration). The other members, such as `tasks`, `ports`, `services`, `events`, `throws` and
/// `doc`, are as printed by `genomctl describe`; `uses` contains what it prints as `remotes`.
#[utoipa::path(
    get,
    path = "/components/{component}",
    tag = "components",
    responses((status = 200, body = Description), (status = 404))
)]
pub(crate) async fn describe(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    // The description in the form of the offline tools, with the members of this instance added.
    let mut reply = tools::describe(hosted.specification(), hosted.model());
    let described = reply["services"].as_array_mut().into_iter().flatten();
    for (index, service) in hosted.model().services.places().zip(described) {
        service["served"] = hosted.served_on(index).into();
    }
    // `remotes` contains only names here; `uses` describes them.
    let remotes = reply.as_object_mut().and_then(|reply| reply.shift_remove("remotes"));
    reply["uses"] = remotes.unwrap_or_default();
    let own = serde_json::to_value(summary(&hosted));
    if let (Value::Object(reply), Ok(Value::Object(own))) = (&mut reply, own) {
        reply.extend(own);
    }
    Ok(Json(reply))
}

/// Get the types of a component as JSON Schemas: inputs and outputs of services, and ports.
///
/// Documentation and defaults are those of the description. `$defs` contains the named types.
#[utoipa::path(
    get,
    path = "/components/{component}/schema",
    tag = "components",
    responses((status = 200, body = Object), (status = 404))
)]
pub(crate) async fn schema(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = find(&supervisor.components, &component)?;
    Ok(Json(tools::schema(hosted.specification(), hosted.model())))
}

/// Load a component and start its tasks.
#[utoipa::path(
    post,
    path = "/components",
    tag = "components",
    request_body = LoadRequest,
    responses((status = 201, body = Component), (status = 404), (status = 409), (status = 422))
)]
pub(crate) async fn load(
    State(daemon): State<Arc<Daemon>>,
    Body(mut request): Body<LoadRequest>,
) -> Result<(StatusCode, Json<Component>), RpcError> {
    if daemon.cells.of(&request.instance()).is_some() {
        return Err(refused(&LoadError::Taken(request.instance())));
    }
    if daemon.own_cell.is_none() {
        isolate_scripts([&mut request], &daemon.supervisor.settings.path);
    }
    match (&daemon.own_cell, request.cell.clone()) {
        (None, Some(cell)) => return load_into(&daemon, &cell, &request).await,
        (Some(_), _) => own_cell::share(&mut request),
        (None, None) => {}
    }
    let supervisor = &daemon.supervisor;
    let worker = Arc::clone(supervisor);
    let loaded = tokio::task::spawn_blocking(move || worker.load(&request)).await;
    match loaded {
        Ok(Ok(hosted)) => Ok((StatusCode::CREATED, Json(summary(&hosted)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// Loads a component into a cell.
async fn load_into(
    daemon: &Daemon,
    cell: &str,
    request: &LoadRequest,
) -> Result<(StatusCode, Json<Component>), RpcError> {
    if daemon.supervisor.components.get(&request.instance()).is_some() {
        return Err(refused(&LoadError::Taken(request.instance())));
    }
    let mut loaded = daemon.cells.load(cell, request).await.map_err(cells::refused)?;
    loaded.cell = Some(cell.to_owned());
    Ok((StatusCode::CREATED, Json(loaded)))
}

/// Exchange the library of a running component.
///
/// IDS, ports, connections and activities stay as they are: each activity goes on in its state, with
/// the new code. A library that does not fit is refused, and the component goes on as before.
#[utoipa::path(
    post,
    path = "/components/{component}/reload",
    tag = "components",
    request_body = ReloadRequest,
    responses(
        (status = 200, body = ComponentReload), (status = 404), (status = 409), (status = 422),
        (status = 503)
    )
)]
pub(crate) async fn reload(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
    Body(request): Body<ReloadRequest>,
) -> Result<Json<ComponentReload>, RpcError> {
    find(&supervisor.components, &component)?;
    let work = move || supervisor.reload(&component, &request);
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(reloaded)) => Ok(Json(reloaded)),
        Ok(Err(error)) => Err(not_reloaded(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn not_reloaded(error: &ReloadError) -> RpcError {
    let message = error.to_string();
    let refused = match error {
        ReloadError::NotThere(_) => RpcError::conflict(Code::Unloading, message),
        ReloadError::Busy(_) => RpcError::conflict(Code::Reloading, message),
        ReloadError::Load(error) => refused(error),
        ReloadError::NoRest(NoRest::HeldUp(error)) => return held_up(error),
        ReloadError::NoRest(NoRest::NoPause { .. }) | ReloadError::Freeze(_) => {
            RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::HeldUp, message)
        }
        ReloadError::Unload(_) | ReloadError::Lost { .. } => {
            return RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::LeftBehind, message)
                .help("`genomctl list` tells what runs; `genomctl load` loads it again");
        }
        ReloadError::NoRest(NoRest::Stops { .. }) => RpcError::conflict(Code::Unloading, message),
        _ => RpcError::new(StatusCode::UNPROCESSABLE_ENTITY, Code::NotLoadable, message)
            .place("/library"),
    };
    refused.help("nothing was changed: the component goes on as before")
}

/// Stop a component's activities and tasks, and close its library.
#[utoipa::path(
    delete,
    path = "/components/{component}",
    tag = "components",
    responses((status = 200, body = Unloaded), (status = 404), (status = 409), (status = 503))
)]
pub(crate) async fn unload(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Path(component): Path<String>,
) -> Result<Json<Unloaded>, RpcError> {
    if let Some(cell) = cells.of(&component) {
        let unloaded = cells.unload(&cell, &component).await;
        return unloaded.map(Json).map_err(cells::refused);
    }
    find(&supervisor.components, &component)?;
    let worker = Arc::clone(&supervisor);
    match tokio::task::spawn_blocking(move || worker.unload(&component)).await {
        Ok(Ok(())) => Ok(Json(Unloaded { unloaded: true })),
        Ok(Err(error @ UnloadError::NotThere(_))) => {
            Err(RpcError::conflict(Code::Unloading, error.to_string()))
        }
        Ok(Err(error @ UnloadError::Stuck { .. })) => {
            let status = StatusCode::SERVICE_UNAVAILABLE;
            Err(RpcError::new(status, Code::LeftBehind, error.to_string())
                .help("`genomctl list` tells until it has ended; restart genomd to be rid of it"))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn summary(hosted: &Hosted) -> Component {
    let bindings = &hosted.ties.bindings;
    let spins = hosted.spins();
    let spinning = || {
        let longest = spins.iter().max_by_key(|spin| spin.unpaused.for_ns)?;
        let (codel, time) = (&longest.unpaused.codel, seconds(longest.unpaused.for_ns));
        Some(format!("spins in {codel} for {time}"))
    };
    Component {
        name: hosted.name.clone(),
        component: hosted.model().name.clone(),
        state: match hosted.damage() {
            Some(_) => "damaged".to_owned(),
            None if hosted.is_held() => "held".to_owned(),
            None => hosted.stuck_in().or_else(spinning).unwrap_or_else(|| "running".to_owned()),
        },
        stuck: hosted.stuck().iter().map(codels::running).collect(),
        spins: spins.iter().map(codels::spin).collect(),
        backend: bindings.component(),
        port_backends: bindings.ports(),
        cell: None,
        library: hosted.library(),
        activities: hosted.activities.running(),
        supervision: hosted.rules(),
        notes: hosted.notes.clone(),
        remotes: hosted.model().remotes.iter().map(|remote| remote.name.clone()).collect(),
    }
}

fn refused(error: &LoadError) -> RpcError {
    let message = error.to_string();
    match error {
        LoadError::Taken(_) => RpcError::conflict(Code::NameTaken, message)
            .help("give this instance another name")
            .place("/name"),
        LoadError::Backend(BackendError::Unknown { .. }) => {
            RpcError::bad_input(message).place("/backend")
        }
        LoadError::Locate(_) => {
            RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchLibrary, message).place("/library")
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
        LoadError::Supervision { .. } => RpcError::bad_input(message).place("/supervision"),
        LoadError::Stopping => RpcError::conflict(Code::Stopping, message),
        _ => RpcError::new(StatusCode::UNPROCESSABLE_ENTITY, Code::NotLoadable, message)
            .place("/library"),
    }
}
