//! Connections: what feeds which in port.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_protocol::{
    Code, Connection as Made, ConnectionKind, ConnectionRequest, Connections, Disconnected,
    NoPolicy, Policy,
};

use crate::config::terms;
use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;
use crate::rpc::{components, ports};
use crate::wires::{Connection, RemoteConnection};
use crate::wiring::remote::{self, RemoteError, RemoteRequest};
use crate::wiring::{self, ConnectError, ConnectRequest};

/// List the connections.
#[utoipa::path(
    get,
    path = "/connections",
    tag = "wiring",
    security(("token" = ["read"])),
    responses((status = 200, body = Connections))
)]
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Connections> {
    let mut connections = Vec::new();
    for hosted in daemon.components.all() {
        connections.extend(hosted.wires.connections().iter().map(of_port));
        connections.extend(hosted.wires.remotes().iter().map(of_remote));
    }
    Json(Connections { connections })
}

/// Connect an in port to an out port, or a remote to a service.
///
/// A remote takes no policy. The other side may belong to another daemon.
#[utoipa::path(
    post,
    path = "/connections",
    tag = "wiring",
    security(("token" = ["wire"])),
    request_body = ConnectionRequest,
    responses(
        (status = 201, body = genom_protocol::Connection), (status = 404), (status = 409), (status = 422), (status = 502),
        (status = 503)
    )
)]
pub(crate) async fn connect(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<ConnectionRequest>,
) -> Result<(StatusCode, Json<Made>), RpcError> {
    if remote::named(&daemon, &wanted.inport).is_some() {
        return connect_remote(daemon, wanted).await;
    }
    let policy = match &wanted.policy {
        None => Policy::default(),
        Some(text) => text
            .parse()
            .map_err(|error: NoPolicy| RpcError::bad_input(error.to_string()).place("/policy"))?,
    };
    let request = ConnectRequest {
        inport: wanted.inport,
        outport: wanted.outport,
        policy: terms::policy(policy),
        backend: wanted.backend,
        wait: wanted.wait,
        patience: wiring::connect::Patience::Full,
    };
    let work = move || {
        let connection = wiring::connect::connect(&daemon, &request)?;
        daemon.declared.forget(&request.inport);
        Ok(connection)
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(of_port(&connection)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

async fn connect_remote(
    daemon: Arc<Daemon>,
    wanted: ConnectionRequest,
) -> Result<(StatusCode, Json<Made>), RpcError> {
    let ConnectionRequest { inport: remote, outport: service, policy, backend, wait } = wanted;
    if policy.is_some() {
        let message = format!("{remote} is a remote: it takes a service, and no policy");
        return Err(RpcError::bad_input(message).place("/policy"));
    }
    let request =
        RemoteRequest { remote, service, backend, wait, patience: wiring::connect::Patience::Full };
    let work = move || {
        let connection = remote::connect(&daemon, &request)?;
        daemon.declared.forget(&request.remote);
        Ok(connection)
    };
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(of_remote(&connection)))),
        Ok(Err(error)) => {
            let (status, code, place) = match &error {
                RemoteError::NoSuchRemote { .. } => {
                    (StatusCode::NOT_FOUND, Code::NoSuchRemote, "/in")
                }
                RemoteError::NoSuchService { .. } => {
                    (StatusCode::NOT_FOUND, Code::NoSuchService, "/out")
                }
                RemoteError::Differs { .. } => (StatusCode::CONFLICT, Code::TypeMismatch, "/out"),
                RemoteError::Backend(error) => {
                    return Err(RpcError::bad_input(error.to_string()).place("/backend"));
                }
                RemoteError::HeldUp(error) => return Err(RpcError::held_up(error)),
                RemoteError::Failed(_) => (StatusCode::BAD_GATEWAY, Code::MiddlewareFailed, "/out"),
            };
            Err(RpcError::new(status, code, error.to_string()).place(place))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// Disconnect an in port or a remote.
#[utoipa::path(
    delete,
    path = "/connections/{component}/{port}",
    tag = "wiring",
    security(("token" = ["wire"])),
    responses(
        (status = 200, body = Disconnected), (status = 404), (status = 409), (status = 503)
    )
)]
pub(crate) async fn disconnect(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Disconnected>, RpcError> {
    take_away(daemon, component, port, None).await
}

/// Disconnect an element of a multiple in port.
#[utoipa::path(
    delete,
    path = "/connections/{component}/{port}/{element}",
    tag = "wiring",
    security(("token" = ["wire"])),
    responses(
        (status = 200, body = Disconnected), (status = 404), (status = 409), (status = 503)
    )
)]
pub(crate) async fn disconnect_element(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port, element)): Path<(String, String, String)>,
) -> Result<Json<Disconnected>, RpcError> {
    take_away(daemon, component, port, Some(element)).await
}

async fn take_away(
    daemon: Arc<Daemon>,
    component: String,
    port: String,
    element: Option<String>,
) -> Result<Json<Disconnected>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let address = hosted.address(&port, element.as_deref());
    let work = if let Some((caller, index)) = remote::named(&daemon, &address.to_string()) {
        let declared = address.to_string();
        tokio::task::spawn_blocking(move || {
            daemon.declared.forget(&declared);
            remote::disconnect(&daemon, &caller, index)
        })
    } else {
        let index = ports::find(&hosted, &port)?;
        tokio::task::spawn_blocking(move || {
            daemon.declared.forget(&hosted.address(&port, element.as_deref()).to_string());
            wiring::connect::disconnect(&daemon, &hosted, index, element.as_deref())
        })
    };
    match work.await {
        Ok(Err(error)) => Err(RpcError::held_up(&error)),
        Ok(Ok(true)) => Ok(Json(Disconnected { disconnected: address.to_string() })),
        Ok(Ok(false)) => {
            Err(RpcError::conflict(Code::NotConnected, format!("{address} is not connected")))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn of_port(connection: &Connection) -> Made {
    Made {
        kind: ConnectionKind::Port,
        inport: connection.inport.to_string(),
        outport: connection.outport.to_string(),
        backend: Some(connection.backend.to_string()),
        policy: Some(terms::told_policy(connection.policy).to_string()),
    }
}

fn of_remote(connection: &RemoteConnection) -> Made {
    Made {
        kind: ConnectionKind::Service,
        inport: connection.remote.to_string(),
        outport: connection.service.to_string(),
        backend: connection.backend.clone(),
        policy: None,
    }
}

fn refused(error: &ConnectError) -> RpcError {
    let message = error.to_string();
    let refused = match error {
        ConnectError::HeldUp(error) => RpcError::held_up(error),
        // The code says it already, which codels see in the message alone.
        ConnectError::NoSuchInport { message, .. } => {
            RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchInport, message).place("/in")
        }
        ConnectError::NoSuchOutport { message, .. } => {
            RpcError::new(StatusCode::NOT_FOUND, Code::NoSuchOutport, message).place("/out")
        }
        ConnectError::Type { .. } => RpcError::conflict(Code::TypeMismatch, message).place("/out"),
        ConnectError::Backend(_) => RpcError::bad_input(message).place("/backend"),
        ConnectError::Failed(_) => {
            RpcError::new(StatusCode::BAD_GATEWAY, Code::MiddlewareFailed, message)
        }
    };
    match error.help() {
        Some(help) => refused.help(help),
        None => refused,
    }
}
